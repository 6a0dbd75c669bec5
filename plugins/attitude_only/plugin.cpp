// SPDX-License-Identifier: Apache-2.0
// What the plugin `attitude_only` brings.
#include "binnacle/plugin.hpp"

#include "attitude_only.hpp"

BINNACLE_TYPES("attitude_only");

BINNACLE_PLUGIN("attitude_only", "1.0.0", registry) { registry.add<binnacle::attitude_only::AttitudeOnly>(); }
