// SPDX-License-Identifier: Apache-2.0
// The plugin vehicle_simulator.
#include "binnacle/plugin.hpp"
#include "simulator.hpp"

BINNACLE_TYPES("vehicle_simulator");

BINNACLE_PLUGIN("vehicle_simulator", "1.0.0", registry) {
  registry.add<binnacle::vehicle_simulator::VehicleSimulator>();
}
