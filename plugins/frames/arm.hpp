// SPDX-License-Identifier: Apache-2.0
// A lever arm in body axes: a parameter, a block, or the sum of both.
#pragma once

#include <Eigen/Core>

#include "binnacle/binding.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

inline ParameterSpec arm_parameter() {
  return parameter::vector("arm", "m", 3).about("from the IMU to the point: forward, right, down in body axes");
}

inline PortSpec arm_port() {
  return may_read("arm", "vector:3:m", "an arm in body axes that is estimated; adds to the parameter 'arm'");
}

/// The fixed part. An arm that is neither given nor plugged in is a mistake, not zero.
inline Eigen::Vector3d fixed_arm(const Binding& binding) {
  if (binding.parameters().has("arm")) return binding.parameters().vector("arm");
  if (!binding.is_bound("arm"))
    throw ComponentError("there is no arm: give 'arm', or plug a vector:3:m block into port 'arm'", "/arm");
  return Eigen::Vector3d::Zero();
}

}  // namespace binnacle::frames
