// SPDX-License-Identifier: Apache-2.0
// The plugin ship_simulator.
#include "binnacle/plugin.hpp"
#include "simulator.hpp"

BINNACLE_TYPES("ship_simulator");

BINNACLE_PLUGIN("ship_simulator", "1.0.0", registry) { registry.add<binnacle::ship_simulator::ShipSimulator>(); }
