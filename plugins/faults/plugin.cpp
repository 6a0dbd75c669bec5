// SPDX-License-Identifier: Apache-2.0
// What the plugin `faults` brings.
#include "binnacle/plugin.hpp"

#include "faults.hpp"

BINNACLE_TYPES("faults");

BINNACLE_PLUGIN("faults", "1.0.0", registry) { registry.add<binnacle::faults::Faults>(); }
