// SPDX-License-Identifier: Apache-2.0
// The plugin tracker: several targets by range and bearing, with association.
#include "radar_simulator.hpp"
#include "scan.hpp"

BINNACLE_PLUGIN("tracker", "1.0.0", registry) {
  registry.add<Scan>();
  registry.add<RadarSimulator>();
}
