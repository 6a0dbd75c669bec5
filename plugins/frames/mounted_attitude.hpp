// SPDX-License-Identifier: Apache-2.0
// The attitude of other axes fixed to the body: the vehicle that the IMU is mounted in.
#pragma once

#include <Eigen/Core>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// C_nv = C_nb Mᵀ exp(−[ζ×]), M = mounting_rotation: from body to vehicle axes. ζ [rad] is in vehicle axes; with M = I
/// it is paper 001 (5), C_v^b = I − [ζ×], so that (7) v_y^b = −ζ_z v_x, v_z^b = +ζ_y v_x.
/// J: I for the attitude, −C_nb Mᵀ J_l(−ζ) for ζ (J_l: left Jacobian).
class MountedAttitude final : public legacy::DerivedBlock {
 public:
  static ComponentSpec spec();
  explicit MountedAttitude(const Binding& binding);

  const DerivedDeclaration& declaration() const noexcept override { return declaration_; }
  Result evaluate(const double* const* x, const legacy::Context& context, double* value,
                  const MatrixView* J) const override;

 private:
  DerivedDeclaration declaration_;
  Eigen::Vector4d q_bv_;  // vehicle to body, without misalignment
  bool has_misalignment_;
};

}  // namespace binnacle::frames
