// SPDX-License-Identifier: Apache-2.0
// A receiver that moves with nearly constant velocity: the GPS-only filter.
#pragma once

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

/// ṙ = v, v̇ = w, with the same density S_a [m²/s³] in each direction, or one along the horizontal and one along the
/// ellipsoid's normal u: S = S_h (I − u uᵀ) + S_v u uᵀ, u at the step's begin: six of the eight states of paper 003, section 4.2.
class EcefPv final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit EcefPv(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 private:
  Port position_, velocity_;
  PhiBlock phi_pv_;
  QBlock q_pp_, q_pv_, q_vv_;
  bool is_isotropic_;
  double S_a_, S_a_vertical_;  // of one density both are it
  double S_v_;                 // of the velocity
};

}  // namespace binnacle::gnss_range
