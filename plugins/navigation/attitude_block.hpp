// SPDX-License-Identifier: Apache-2.0
// An attitude with its error as tilt in navigation axes.
#pragma once

#include <Eigen/Core>

#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle::navigation {

/// Stored: quaternion (w, x, y, z), body to navigation. Error: phi north, east, down [rad], q_true = exp(phi) ⊗ q̂,
/// that is Ĉ = (I − [φ×]) C as in papers 001 (3) and 003 (3).
/// Outputs: the attitude of the axes r in which the body is mounted by `mounting`, C_nr = C_nb C_rbᵀ. For a body that
/// stands upright on a ship, angles of its own would be read where roll and yaw are one turn.
class AttitudeBlock final : public StateBlock {
 public:
  static ComponentSpec spec();
  explicit AttitudeBlock(const Binding& binding);

  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override;
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override;
  void read(ConstVectorView x, VectorView outputs) const override;
  Result write(ConstVectorView outputs, VectorView x) const override;
  /// exp(φ_new) = exp(φ_old) exp(−δ), so φ_new = J_l(δ) (φ_old − δ) = (I + ½[δ×] + …)(φ_old − δ). With "reset": false it
  /// is not used: what position and velocity at rest do not show is a rotation about the vertical, exp(ψ e) exp(τ) of
  /// any ψ, and J_l would turn the axis e of that ψ into the tilt by each correction of τ.
  bool reset_jacobian(ConstVectorView /*x*/, ConstVectorView delta, MatrixView G) const override;
  /// Of strapdown::euler_jacobian(); false near the vertical.
  bool output_jacobian(ConstVectorView x, MatrixView J) const override;

 private:
  Eigen::Vector4d as_read(ConstVectorView x) const;  // q_nr

  StateBlockDeclaration declaration_;
  Eigen::Vector4d q_rb_;  // body to the axes that are read
  bool is_reset_;
};

}  // namespace binnacle::navigation
