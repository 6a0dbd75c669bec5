// SPDX-License-Identifier: Apache-2.0
// From the sensor to the antenna, with what else the velocities may show in its place.
#pragma once

#include <cstddef>

#include "series.hpp"

namespace binnacle::inspect {

struct LeverArm {
  Vector3d value = Vector3d::Zero();           // in the sensor's axes [m]
  Matrix3d covariance = Matrix3d::Identity();  // by leaving out a window at a time [m^2]
  std::size_t windows = 0;                     // 0: too few
};

/// Velocities of windows of 20 s, north and east, against the lever arm, the delay, and both biases together. In a turn a delay looks as an
/// antenna ahead or behind does: a sigma at a fixed delay would be too small. delay: where the search begins [s].
LeverArm find_lever_arm(const Inertial& inertial, const Fixes& fixes, double delay, const Vector3d& bias);

}  // namespace binnacle::inspect
