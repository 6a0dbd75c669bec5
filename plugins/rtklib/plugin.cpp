// SPDX-License-Identifier: Apache-2.0
// What the plugin `rtklib` brings.
#include "binnacle/plugin.hpp"

#include "pos_source.hpp"

BINNACLE_TYPES("rtklib_pos");

BINNACLE_PLUGIN("rtklib", "1.0.0", registry) { registry.add<binnacle::rtklib::PosSource>(); }
