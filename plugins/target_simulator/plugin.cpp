// SPDX-License-Identifier: Apache-2.0
// The plugin target_simulator.
#include "binnacle/plugin.hpp"
#include "simulator.hpp"

BINNACLE_TYPES("target_simulator");

BINNACLE_PLUGIN("target_simulator", "1.0.0", registry) { registry.add<binnacle::target_simulator::TargetSimulator>(); }
