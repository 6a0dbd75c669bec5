// SPDX-License-Identifier: Apache-2.0
// What the plugin `kitti` brings.
#include "binnacle/plugin.hpp"

#include "oxts_source.hpp"

BINNACLE_TYPES("oxts");

BINNACLE_PLUGIN("kitti", "1.0.0", registry) { registry.add<binnacle::kitti::OxtsSource>(); }
