// SPDX-License-Identifier: Apache-2.0
// The velocity of another point of a turning body.
#pragma once

#include <Eigen/Core>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// v' = v + C_nb (ω_ib × l) − ω_ie × (C_nb l), that is C_nb (ω_eb × l) in the navigation axes of the IMU.
/// ω_ib = (drive − gyro_bias)/(1 + gyro_scale); l = `lever_arm` + the block on port `lever_arm`. The transport rate turns the
/// axes, not the body against the earth, so it does not enter. Without a position the earth rate is left out
/// (7.3e-5 |l| m/s).
/// With u = C_nb (ω_ib × l), a = C_nb l, D = diag(1/(1 + gyro_scale)):
///   J_velocity = I             J_attitude = −[u×] + [ω_ie×][a×]     J_gyro_bias = C_nb [l×] D
///   J_arm = C_nb [ω_ib×] − [ω_ie×] C_nb      J_gyro_scale = C_nb [l×] D diag(ω_ib)
///   J_position = −(∂ω_ie/∂N × a) in its first column
class LeverArmVelocity final : public legacy::DerivedBlock {
 public:
  static ComponentSpec spec();
  explicit LeverArmVelocity(const Binding& binding);

  const DerivedDeclaration& declaration() const noexcept override { return declaration_; }
  Result evaluate(const double* const* x, const legacy::Context& context, double* value,
                  const MatrixView* J) const override;

 private:
  DerivedDeclaration declaration_;
  Eigen::Vector3d lever_arm_;  // m
};

}  // namespace binnacle::frames
