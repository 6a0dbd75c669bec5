// SPDX-License-Identifier: Apache-2.0
// What the plugin `ublox` brings.
#include "binnacle/plugin.hpp"

#include "ublox_source.hpp"

BINNACLE_TYPES("ublox");

BINNACLE_PLUGIN("ublox", "1.0.0", registry) { registry.add<binnacle::ublox::UbloxSource>(); }
