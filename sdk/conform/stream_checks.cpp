// SPDX-License-Identifier: Apache-2.0
// numbers.source and numbers.transform: samples come in order and say what they declared.
#include <cmath>

#include "fixture.hpp"
#include "miniature.hpp"

namespace binnacle::conform {

namespace {

void source_order(Trial& trial) {
  const auto subject = fixture_of_example(trial);
  auto memory = subject->fresh_memory();
  double last = -INFINITY;
  const int most = trial.repeats(5000);
  int count = 0;
  bool has_number = false;
  for (int k = 0; k < most; ++k) {
    const Answer answer = subject->turn(static_cast<std::uint64_t>(k), memory.data(), std::nan(""));
    const auto status = static_cast<SourceStatus>(static_cast<int>(answer.numbers.front()));
    if (!trial.expect(status != SourceStatus::error, "its example ends with an error after ", count, " samples"))
      return;
    if (status == SourceStatus::wait && count == 0)
      Trial::not_applicable("it waits for live input, and its example has no sample of its own");
    if (status != SourceStatus::sample) break;
    ++count;
    const double t = answer.numbers[2];
    if (!trial.expect(t != static_cast<double>(no_time), "sample ", count, " has no time")) return;
    if (!trial.expect(t >= last, "sample ", count, " goes back in time, from ", last * 1e-9, " s to ", t * 1e-9, " s"))
      return;
    last = t;
    for (std::size_t i = 3; i < answer.numbers.size(); ++i) has_number |= std::isfinite(answer.numbers[i]);
  }
  if (count == 0) Trial::skip("its example has no sample of its own");
  trial.expect(has_number, "none of its samples has a number");
}

void transform_order(Trial& trial) {
  const auto subject = fixture_of_example(trial);
  auto memory = subject->fresh_memory();
  double last = -INFINITY;
  for (int k = 0; k < trial.repeats(2000); ++k) {
    const Answer answer = subject->turn(static_cast<std::uint64_t>(k), memory.data(), std::nan(""));
    if (answer.numbers.size() < 2) continue;
    const double t = answer.numbers[1];
    if (!trial.expect(t >= last, "what it emits goes back in time, from ", last * 1e-9, " s to ", t * 1e-9, " s"))
      return;
    last = t;
  }
}

}  // namespace

std::vector<Check> stream_checks() {
  return {
      check("numbers.source.order", 2, {Role::source}, {"life.repeatable"},
            "samples come in order of time and carry numbers", source_order),
      check("numbers.transform.order", 2, {Role::transform}, {"life.repeatable"},
            "what it emits comes in order of time", transform_order),
  };
}

}  // namespace binnacle::conform
