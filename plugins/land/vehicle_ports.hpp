// SPDX-License-Identifier: Apache-2.0
// The ports of a velocity in the vehicle's axes.
#pragma once

#include <vector>

#include "vehicle/vehicle_velocity.hpp"

namespace binnacle::land {

inline std::vector<PortSpec> vehicle_ports() {
  return vehicle::VehicleVelocity::ports(
      "of the point that does not slip: a lever_arm_velocity to the rear axle",
      "of the vehicle as it is thought to be: a mounted_attitude unless the IMU's axes are its");
}

}  // namespace binnacle::land
