// SPDX-License-Identifier: Apache-2.0
// The plugin coning_simulator.
#include "binnacle/plugin.hpp"
#include "simulator.hpp"

BINNACLE_TYPES("coning_simulator");

BINNACLE_PLUGIN("coning_simulator", "1.0.0", registry) { registry.add<binnacle::coning_simulator::ConingSimulator>(); }
