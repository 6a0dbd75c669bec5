// SPDX-License-Identifier: Apache-2.0
// What the plugin `frames` brings.
#include "binnacle/plugin.hpp"

#include "lever_arm.hpp"
#include "lever_arm_velocity.hpp"
#include "local_position.hpp"
#include "mounted_attitude.hpp"
#include "rotate_axes.hpp"

BINNACLE_TYPES(
    "lever_arm lever_arm_velocity mounted_attitude geodetic_from_local local_from_geodetic "
    "rotate_axes");

BINNACLE_PLUGIN("frames", "1.0.0", registry) {
  using namespace binnacle::frames;
  registry.add<LeverArm>();
  registry.add<LeverArmVelocity>();
  registry.add<MountedAttitude>();
  registry.add<LocalFromGeodetic>();
  registry.add<GeodeticFromLocal>();
  registry.add<RotateAxes>();
}
