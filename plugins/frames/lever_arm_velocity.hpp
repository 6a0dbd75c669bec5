// SPDX-License-Identifier: Apache-2.0
// The velocity of another point of a turning body.
#pragma once

#include <Eigen/Core>

#include "binnacle/derived_block.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// v' = v + C_nb (ω_ib × l) − ω_ie × (C_nb l), that is C_nb (ω_eb × l) in the navigation axes of the IMU.
/// ω_ib = (driving rates − gyro_bias)/(1 + gyro_scale); l = `lever_arm` + the block on port `lever_arm`. The transport rate turns the
/// axes, not the body against the earth, so it does not enter. Without a position the earth rate is left out
/// (7.3e-5 |l| m/s).
/// With u = C_nb (ω_ib × l), a = C_nb l, D = diag(1/(1 + gyro_scale)):
///   J_velocity = I             J_attitude = −[u×] + [ω_ie×][a×]     J_gyro_bias = C_nb [l×] D
///   J_arm = C_nb [ω_ib×] − [ω_ie×] C_nb      J_gyro_scale = C_nb [l×] D diag(ω_ib)
///   J_position = −(∂ω_ie/∂N × a) in its first column
class LeverArmVelocity final : public DerivedBlock {
 public:
  static ComponentSpec spec();
  explicit LeverArmVelocity(const Binding& binding);

  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override;

 private:
  Port velocity_, attitude_, position_, gyro_bias_, gyro_scale_, lever_arm_port_;
  DrivingRateVector<3> omega_;
  Eigen::Vector3d lever_arm_;  // m
};

}  // namespace binnacle::frames
