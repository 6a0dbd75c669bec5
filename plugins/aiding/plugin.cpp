// SPDX-License-Identifier: Apache-2.0
// What the plugin `aiding` brings.
#include "binnacle/plugin.hpp"
#include "bearing.hpp"

BINNACLE_PLUGIN("aiding", "1.0.0", registry) { registry.add<binnacle::aiding::Bearing>(); }
