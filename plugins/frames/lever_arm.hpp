// SPDX-License-Identifier: Apache-2.0
// The position of another point of the body: an antenna, an axle.
#pragma once

#include <Eigen/Core>

#include "binnacle/derived_block.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// p' = p ⊞ C_nb l, with l the parameter `lever_arm` plus the block on port `lever_arm` [m, body axes].
/// J: I for the position, −[(C_nb l)×] for the attitude (C_true = exp([phi×]) C), C_nb for the lever arm.
/// The metres are taken by the radii of curvature at p: J is good to |l| tan(lat)/R, 1e-6 for a lever arm of 5 m.
class LeverArm final : public DerivedBlock {
 public:
  static ComponentSpec spec();
  explicit LeverArm(const Binding& binding);

  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override;

 private:
  Port position_, attitude_, lever_arm_port_;
  Eigen::Vector3d lever_arm_;  // m
};

}  // namespace binnacle::frames
