// SPDX-License-Identifier: Apache-2.0
// A lever arm in body axes: a parameter, a block, or the sum of both.
#pragma once

#include <Eigen/Core>

#include "binnacle/binding.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

inline ParameterSpec lever_arm_parameter() {
  return parameter::vector("lever_arm", "m", 3)
      .formerly("arm")
      .plausible(0, 100)
      .about("lever arm from the IMU to the point: forward, right, down in body axes");
}

inline PortSpec lever_arm_port() {
  return reads("lever_arm", "vector:3:m")
      .optional()
      .formerly("arm")
      .about("estimated lever arm in body axes; added to the parameter 'lever_arm'");
}

/// The fixed part. A lever arm that is neither given nor plugged in is a mistake, not zero.
inline Eigen::Vector3d fixed_lever_arm(const Binding& binding) {
  if (binding.parameters().has("lever_arm")) return binding.parameters().vector("lever_arm");
  if (!binding.port("lever_arm").is_bound())
    throw ComponentError("there is no lever arm: give 'lever_arm', or plug a vector:3:m block into port 'lever_arm'",
                         "/lever_arm");
  return Eigen::Vector3d::Zero();
}

}  // namespace binnacle::frames
