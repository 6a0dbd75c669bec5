// SPDX-License-Identifier: Apache-2.0
// The clock of the simulators: instants by rate, and none for a tick that no run counts.
#include "simulation/clock.hpp"

#include <cstdint>
#include <limits>

#include "catch.hpp"

namespace simulation_clock_test {

using binnacle::Time;
using binnacle::simulation::Clock;
using binnacle::simulation::never;

TEST_CASE("a simulator's clock is due at each tick up to the end, the end itself included") {
  const Clock thirds(3.0);
  CHECK(thirds.due(0, 666'666'667) == 0);
  CHECK(thirds.due(1, 666'666'667) == 333'333'333);
  CHECK(thirds.due(2, 666'666'667) == 666'666'667);  // two thirds, rounded up
  CHECK(thirds.due(2, 666'666'666) == never);
  CHECK(thirds.interval_before(2) == Approx(0.333'333'334));
  CHECK(Clock(0.0).due(0, 1) == never);
}

TEST_CASE("a simulator's clock is never due at a tick that no run counts") {
  const Clock clock(200.0);
  constexpr Time end = std::numeric_limits<Time>::max() / 2;
  for (const std::int64_t damaged : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1},
                                     std::int64_t{1'900'000'000'000}, std::numeric_limits<std::int64_t>::max()})
    CHECK(clock.due(damaged, end) == never);
}

}  // namespace simulation_clock_test
