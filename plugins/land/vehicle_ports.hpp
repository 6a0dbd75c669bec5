// SPDX-License-Identifier: Apache-2.0
// The ports of a velocity in the vehicle's axes.
#pragma once

#include <vector>

#include "vehicle/vehicle_velocity.hpp"

namespace binnacle::land {

inline std::vector<PortSpec> vehicle_ports() {
  return vehicle::VehicleVelocity::ports(
      "velocity of the point that does not slip: a lever_arm_velocity to the rear axle",
      "nominal attitude of the vehicle: a mounted_attitude, unless its axes are those of the IMU");
}

}  // namespace binnacle::land
