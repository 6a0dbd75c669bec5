// SPDX-License-Identifier: Apache-2.0
// The plugin sphere: a direction as a state block, how it turns, and how it is seen.
#include "direction.hpp"
#include "sighting.hpp"
#include "tumbling_simulator.hpp"
#include "turning.hpp"

BINNACLE_PLUGIN("sphere", "1.0.0", registry) {
  registry.add<Direction>();
  registry.add<Turning>();
  registry.add<Sighting>();
  registry.add<TumblingSimulator>();
}
