// SPDX-License-Identifier: Apache-2.0
// What the plugin `navigation` brings.
#include "binnacle/plugin.hpp"

#include "attitude_block.hpp"
#include "position_block.hpp"
#include "velocity_block.hpp"

BINNACLE_TYPES("attitude position velocity");

BINNACLE_PLUGIN("navigation", "1.0.0", registry) {
  using namespace binnacle::navigation;
  registry.add<PositionBlock>();
  registry.add<VelocityBlock>();
  registry.add<AttitudeBlock>();
}
