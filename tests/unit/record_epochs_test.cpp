// SPDX-License-Identifier: Apache-2.0
// record.every: one instant for every point of the grid, the nearest.
#include "../../sdk/score/record_epochs.hpp"

#include <vector>

#include "catch.hpp"

namespace record_epochs_test {

using namespace binnacle;
using score::RecordEpochs;

namespace {

constexpr Time ms = 1'000'000;

/// The times that a record of `every` takes of these.
std::vector<Time> taken(Time every, const std::vector<Time>& instants) {
  using enum RecordEpochs::Choice;
  RecordEpochs epochs(every);
  std::vector<Time> record;
  Time kept = no_time;
  for (const Time t : instants) {
    const auto verdict = epochs.on(t);
    if (verdict == release || verdict == release_and_take || verdict == release_and_keep) record.push_back(kept);
    if (verdict == take || verdict == release_and_take) record.push_back(t);
    if (verdict == keep || verdict == release_and_keep) kept = t;
  }
  if (epochs.finish()) record.push_back(kept);
  return record;
}

std::vector<Time> in_ms(std::vector<Time> times) {
  for (Time& t : times) t *= ms;
  return times;
}

}  // namespace

TEST_CASE("a record without an interval takes every instant", "[record]") {
  CHECK(taken(0, {0, 1, 5}) == std::vector<Time>{0, 1, 5});
}

TEST_CASE("labels that jitter by a millisecond lose no epoch", "[record]") {
  CHECK(taken(1000 * ms, in_ms({0, 999, 2000, 3001, 3999, 4999, 6000})) ==
        in_ms({0, 999, 2000, 3001, 3999, 4999, 6000}));
  // At ten times the rate of the record: the label nearest to the grid, before or after it.
  CHECK(taken(1000 * ms, in_ms({0, 101, 199, 899, 999, 1100, 1901, 2001, 2100, 2899, 2999})) ==
        in_ms({0, 999, 2001, 2999}));
}

TEST_CASE("data that hit the grid are taken there, and nothing is kept for later", "[record]") {
  RecordEpochs epochs(200 * ms);
  for (Time t = 0; t <= 1000; t += 10) {
    const auto verdict = epochs.on(t * ms);
    CHECK(verdict == (t % 200 == 0 ? RecordEpochs::Choice::take : RecordEpochs::Choice::skip));
  }
}

TEST_CASE("of an instant just before a point and one just after it, the nearer is taken", "[record]") {
  CHECK(taken(100 * ms, in_ms({0, 50, 97, 102, 150, 198, 205})) == in_ms({0, 102, 198}));
  CHECK(taken(100 * ms, in_ms({0, 50, 97, 99, 150})) == in_ms({0, 99}));
  CHECK(taken(100 * ms, in_ms({0, 95, 105})) == in_ms({0, 105}));               // the later of two that are as near
  CHECK(taken(100 * ms, in_ms({0, 75, 85, 95, 105, 115})) == in_ms({0, 105}));  // half way between points
}

TEST_CASE("far from a point the first instant behind it is taken, as are the points behind a hole", "[record]") {
  CHECK(taken(100 * ms, in_ms({0, 80, 140, 210, 260, 520, 590, 600})) == in_ms({0, 140, 210, 520, 600}));
}

TEST_CASE("an instant that was kept is not lost at a hole or at the end", "[record]") {
  CHECK(taken(100 * ms, in_ms({0, 95, 350, 395})) == in_ms({0, 95, 350, 395}));
}

}  // namespace record_epochs_test
