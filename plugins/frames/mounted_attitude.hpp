// SPDX-License-Identifier: Apache-2.0
// The attitude of other axes fixed to the body: the vehicle that the IMU is mounted in.
#pragma once

#include <Eigen/Core>

#include "binnacle/derived_block.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// C_nv = C_nb Mᵀ exp(−[ζ×]), M = mounting_rotation: from body to vehicle axes. ζ [rad] is in vehicle axes; with M = I
/// it is paper 001 (5), C_v^b = I − [ζ×], so that (7) v_y^b = −ζ_z v_x, v_z^b = +ζ_y v_x.
/// J: I for the attitude, −C_nb Mᵀ J_l(−ζ) for ζ (J_l: left Jacobian).
class MountedAttitude final : public DerivedBlock {
 public:
  static ComponentSpec spec();
  explicit MountedAttitude(const Binding& binding);

  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override;

 private:
  Port attitude_, misalignment_;
  Eigen::Vector4d q_bv_;  // vehicle to body, without misalignment
};

}  // namespace binnacle::frames
