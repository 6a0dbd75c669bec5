// SPDX-License-Identifier: Apache-2.0
// Snapshots that are damaged: refused, whatever was done to them; and where their checksum is right all the same, refused or
// gone on with, never more than that.
#include "snapshot_attack.hpp"

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <random>
#include <string>

#include "catch.hpp"
#include "compose/composition_plan.hpp"
#include "line.hpp"

namespace snapshot_test {

using namespace binnacle;
using namespace snapshot_attack;

namespace {

std::shared_ptr<const Composition> ins(const std::string& form) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = {"/filters/ins/covariance=" + form};
  return Composition::load(BINNACLE_TEST_PROJECT "/tests/filter/ins.json", options);
}

/// Of a vehicle at rest; a fix waits for the input at its end.
void drive(Session& session, double from, double until) {
  const auto imu = session.channel("imu"), gnss = session.channel("gnss");
  const double increments[] = {1e-6, -1e-6, 2e-6, 1e-4, -1e-4, -0.0981};
  for (double t = from; t < until - 1e-9; t += 0.01) {
    if (std::fmod(t + 1e-9, 0.1) < 0.01) {
      const double fix[] = {0.8377580409572782 + 1e-7 * std::sin(t), 0.19198621771937624, 500 + std::cos(9 * t)};
      session.push(gnss, no_time, nanoseconds(t + 0.025), fix);
    }
    session.push(imu, nanoseconds(t), nanoseconds(t + 0.01), increments);
  }
}

/// A clone, an estimator of noise, and samples that repeat.
std::string wanderer() {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}},
                "way": {"type": "pushed", "fields": {"dx": {"unit": "m", "kind": "increment"}}}},
    "filters": {"f": {"blocks": {
        "x": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2},
        "then": {"type": "vector", "size": 1, "unit": "m", "init": 40, "sigma": 5},
        "age": {"type": "vector", "size": 1, "unit": "s", "estimate": []}},
      "process": {
        "walk": {"type": "random_walk", "blocks": {"x": "x"}, "q": 0.4},
        "copy": {"type": "clone", "inputs": {"at": "way"}, "blocks": {"of": "x", "copy": "then", "age": "age"}}},
      "measurements": {
        "fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [0.7], "gate": 0.999,
                "noise": {"type": "huber", "by": "row"}},
        "way": {"type": "relative_position", "channel": "way", "frame": "navigation", "sigma": [0.05, 0.05, 0.05],
                "blocks": {"position": "x", "copy": "then", "age": "age"}}}}}})";
}

void wander(Session& session, int from, int until) {
  const auto z = session.channel("z"), way = session.channel("way");
  for (int k = from; k < until; ++k) {
    const double seen[] = {k % 7 == 3 ? 60.0 : 1 + 0.1 * k}, gone[] = {0.1};
    session.push(z, no_time, nanoseconds(k), seen);
    session.push(way, nanoseconds(k), nanoseconds(k + 0.5), gone);
  }
}

std::string refusal(Session& session, const Bytes& bytes) {
  try {
    session.restore(bytes);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "taken";
}

}  // namespace

TEST_CASE("10 000 damaged snapshots are refused, and each leaves the session as it was") {
  Session session(ins("joseph"));
  drive(session, 0, 3);
  const Bytes whole = snapshot_of(session);
  drive(session, 3, 3.3);
  std::mt19937_64 random(23);
  int taken = 0;
  for (int k = 0; k < 10'000; ++k) taken += is_taken(session, damaged(whole, random));
  CHECK(taken == 0);
  CHECK(is_taken(session, whole));
}

TEST_CASE("each bit of a snapshot counts") {
  Session session(filter_tests::composition_of(filter_tests::line()));
  filter_tests::push(session, "z", 1, {1.5});
  Bytes bytes = snapshot_of(session);
  int taken = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      bytes[at] ^= std::byte{1} << bit;
      taken += refusal(session, bytes) == "taken";
      bytes[at] ^= std::byte{1} << bit;
    }
  CHECK(taken == 0);
  bytes.back() ^= std::byte{1};
  CHECK(refusal(session, bytes).find("its checksum does not match: it is damaged") != std::string::npos);
}

TEST_CASE("a forged snapshot, damaged and sealed again, is refused or gone on with: an INS in each form") {
  for (const char* form : {"joseph", "ud", "square_root"}) {
    Session session(ins(form));
    drive(session, 0, 0.92);
    const Bytes whole = snapshot_of(session);
    std::mt19937_64 random(7);
    int taken = 0;
    const auto begin = std::chrono::steady_clock::now();
    for (int k = 0; k < 3000; ++k)
      taken += survives_forged(session, whole, random, [](Session& its) { drive(its, 0.92, 1.3); });
    CAPTURE(form, taken);
    CHECK(taken > 30);
    CHECK(taken < 3000);
    CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(120));
  }
}

TEST_CASE("a forged snapshot is refused or gone on with: clones, weights, gated samples") {
  Session session(filter_tests::composition_of(wanderer()));
  wander(session, 0, 40);
  const Bytes whole = snapshot_of(session);
  std::mt19937_64 random(11);
  int taken = 0;
  for (int k = 0; k < 5000; ++k)
    taken += survives_forged(session, whole, random, [](Session& its) { wander(its, 40, 50); });
  CAPTURE(taken);
  CHECK(taken > 30);
  CHECK(taken < 5000);
}

TEST_CASE("a forged count, index or time is refused by what it is") {
  Session session(ins("joseph"));
  drive(session, 0, 0.92);
  const Bytes whole = snapshot_of(session);
  const auto& plan = session.composition().plan().filters.front();
  const auto forged = [&](std::size_t offset, auto value) {
    Bytes bytes = whole;
    std::memcpy(bytes.data() + sizeof(Head) + offset, &value, sizeof value);
    reseal(bytes);
    return refusal(session, bytes);
  };
  using internal::filter::QueueEntry;
  using internal::filter::TimeHead;
  const auto is_refused = [](const std::string& text) { return text.find("its content is damaged") != text.npos; };
  CHECK(is_refused(forged(plan.head.offset + offsetof(TimeHead, pending), std::int32_t{-1})));
  CHECK(is_refused(forged(plan.head.offset + offsetof(TimeHead, queued), std::int32_t{1 << 20})));
  CHECK(is_refused(forged(plan.head.offset + offsetof(TimeHead, input_end), no_time)));
  CHECK(is_refused(forged(plan.queue.offset + offsetof(QueueEntry, slot), std::int32_t{1})));
  CHECK(is_refused(forged(plan.queue.offset + offsetof(QueueEntry, measurement), std::int32_t{1})));
  CHECK(is_refused(
      forged(plan.measurements[0].rows.offset + offsetof(internal::filter::RowMonitor, group), std::int32_t{40})));
  CHECK(is_refused(forged(plan.state.offset, std::nan(""))));
  CHECK(is_refused(forged(plan.covariance.offset, -1.0)));
  CHECK(refusal(session, whole) == "taken");
}

}  // namespace snapshot_test
