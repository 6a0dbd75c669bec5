// SPDX-License-Identifier: Apache-2.0
// What the plugin `constellation_simulator` brings.
#include "binnacle/plugin.hpp"

#include "constellation_simulator.hpp"

BINNACLE_TYPES("constellation_simulator");

BINNACLE_PLUGIN("constellation_simulator", "1.0.0", registry) {
  registry.add<binnacle::constellation_simulator::ConstellationSimulator>();
}
