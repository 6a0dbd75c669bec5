// SPDX-License-Identifier: Apache-2.0
// A slave's attitude held against its master's.
#pragma once

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::transfer_match {

/// With A = C_M Ĉ_S^M Ĉ_Sᵀ, C_M from the master's roll, pitch, yaw (paper 000 (3), its third matrix read as C_n^S):
///   r = ½ (A − Aᵀ)∨ = ψ − C_M δμ + v, north east down [rad]                                                    (4)
/// The paper's H is [I, −C_M] (its residual A − I has the same sign as z ⊟ h(x̂), both errors keep theirs). For
/// residuals that are not small, exactly:
///   H_ψ = ½ (tr A I − Aᵀ)      H_μ = −½ (tr A I − A) C_M
/// by [a×]A + Aᵀ[a×] = [((tr A) I − A) a ×]; both are the paper's where A = I.
///
/// That is the tangent at the estimate. Where attitude and mounting are each wrong by much, their common part c (which
/// turns r, and does nothing else) would seem visible through [r×] c, or through nothing in the paper's. With
/// r = log(exp(−m) exp(ψ)) = ψ − m + ½ r × ½(ψ + m) to second order, m = C_M δμ, what is right over the whole of r is
///   H_ψ = I + ¼ [r×]           H_μ = −(I − ¼ [r×]) C_M
/// the mean of both: the chord. P⁺ is then tight where the residual was, after the blocks' reset Jacobians too.
class DcmMatch final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit DcmMatch(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port attitude_, mounting_;
  Fields<3> angles_;  // roll, pitch, yaw of the master
  bool is_chord_;
  Eigen::Vector3d variance_;  // rad²
};

}  // namespace binnacle::transfer_match
