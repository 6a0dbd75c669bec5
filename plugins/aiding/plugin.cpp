// SPDX-License-Identifier: Apache-2.0
// What the plugin `aiding` brings.
#include "bearing.hpp"
#include "binnacle/plugin.hpp"

BINNACLE_PLUGIN("aiding", "1.0.0", registry) { registry.add<binnacle::aiding::Bearing>(); }
