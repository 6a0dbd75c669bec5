// SPDX-License-Identifier: Apache-2.0
// What the plugin `aiding_simulator` brings.
#include "binnacle/plugin.hpp"
#include "simulator.hpp"

BINNACLE_TYPES("aiding_simulator");

BINNACLE_PLUGIN("aiding_simulator", "1.0.0", registry) { registry.add<binnacle::aiding_simulator::AidingSimulator>(); }
