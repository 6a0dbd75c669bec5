// SPDX-License-Identifier: Apache-2.0
// The in_motion_alignment plugin: its components.
#include "binnacle/plugin.hpp"

#include "in_motion_alignment.hpp"

BINNACLE_TYPES("in_motion_alignment");

BINNACLE_PLUGIN("in_motion_alignment", "1.0.0", registry) {
  registry.add<binnacle::in_motion_alignment::InMotionAlignment>();
}
