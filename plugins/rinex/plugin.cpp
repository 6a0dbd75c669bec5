// SPDX-License-Identifier: Apache-2.0
// What the plugin `rinex` brings.
#include "binnacle/plugin.hpp"

#include "rinex_source.hpp"

BINNACLE_TYPES("rinex");

BINNACLE_PLUGIN("rinex", "1.0.0", registry) { registry.add<binnacle::rinex::RinexSource>(); }
