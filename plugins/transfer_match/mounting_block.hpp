// SPDX-License-Identifier: Apache-2.0
// How one inertial system is mounted with respect to another.
#pragma once

#include <Eigen/Core>

#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle::transfer_match {

/// Stored: quaternion (w, x, y, z) of C_S^M, body axes of the slave (SINS) to those of the master (MINS).
/// Error: δμ x, y, z [rad] in the master's axes. Paper 000 (3) and (5), corrected: Ĉ_S^M = (I − [δμ×]) C_S^M, so the
/// feedback is C_S^M = (I + [δμ×]) Ĉ_S^M; carried to all orders it is q_true = exp(δμ) ⊗ q̂. The sign is the paper's, as
/// with every attitude error.
/// Outputs: mx, my, mz [rad], the rotation vector m of C_S^M = exp([m×]) C_nominal.
class MountingBlock final : public StateBlock {
 public:
  static ComponentSpec spec();
  explicit MountingBlock(const Binding& binding);

  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override;
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override;
  void read(ConstVectorView x, VectorView outputs) const override;
  Result write(ConstVectorView outputs, VectorView x) const override;
  /// exp(μ_new) = exp(μ_old) exp(−δ): J_l(δ), as of an attitude.
  bool reset_jacobian(ConstVectorView /*x*/, ConstVectorView delta, MatrixView G) const override;
  bool output_jacobian(ConstVectorView x, MatrixView J) const override;

 private:
  StateBlockDeclaration declaration_;
  Eigen::Vector4d nominal_;  // as stored
};

}  // namespace binnacle::transfer_match
