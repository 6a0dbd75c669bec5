// SPDX-License-Identifier: Apache-2.0
// The plugin walk_simulator.
#include "binnacle/plugin.hpp"
#include "simulator.hpp"

BINNACLE_TYPES("walk_simulator");

BINNACLE_PLUGIN("walk_simulator", "1.0.0", registry) { registry.add<binnacle::walk_simulator::WalkSimulator>(); }
