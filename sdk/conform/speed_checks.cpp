// SPDX-License-Identifier: Apache-2.0
// speed: warnings, for times on one machine prove nothing about another.
#include <algorithm>
#include <chrono>

#include "allocations.hpp"
#include "fixture.hpp"
#include "miniature.hpp"
#include "tried_roles.hpp"

namespace binnacle::conform {

namespace {

CallMeter metered_turns(Trial& trial, int turns) {
  const auto subject = fixture_of_example(trial);
  auto memory = subject->fresh_memory();
  CallMeter meter;
  subject->turn(0, memory.data(), 0.0);
  meter_calls(&meter);
  for (int k = 1; k <= turns; ++k) subject->turn(static_cast<std::uint64_t>(k), memory.data(), 0.0);
  meter_calls(nullptr);
  return meter;
}

void allocation(Trial& trial) {
  const CallMeter meter = metered_turns(trial, trial.repeats(100));
  if (meter.allocations > 0)
    trial.warn("allocates memory in the run loop: ", meter.allocations, " times in ", meter.seconds.size(), " calls");
}

void call(Trial& trial) {
  CallMeter meter = metered_turns(trial, trial.repeats(500));
  if (meter.seconds.empty()) Trial::not_applicable("nothing was called");
  std::sort(meter.seconds.begin(), meter.seconds.end());
  const double p99 = meter.seconds[meter.seconds.size() * 99 / 100];
  if (p99 > 100e-6) trial.warn("one call in a hundred takes longer than ", p99 * 1e6, " us");
}

void construction(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  const Json config = miniature(trial, type, catalog, example_of(type.spec));
  const auto start = std::chrono::steady_clock::now();
  const auto composition = compose(trial, config);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (seconds > 0.5) trial.warn("composing it takes ", seconds, " s");
}

}  // namespace

std::vector<Check> speed_checks() {
  return {
      check("speed.allocations", 4, called_roles, {"life.repeatable"}, "hot calls allocate nothing", allocation),
      check("speed.call", 5, called_roles, {"life.repeatable"}, "99 of 100 calls return within 100 us", call),
      check("speed.construction", 5, called_roles, {"life.create"}, "it is composed within half a second",
            construction),
  };
}

}  // namespace binnacle::conform
