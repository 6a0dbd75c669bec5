// SPDX-License-Identifier: Apache-2.0
// Position and velocity of a GNSS filter, with their full covariance: loose coupling.
#pragma once

#include <array>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_fix {

/// z = (r_e, v_e) with covariance Σ, ECEF. With C = C_en at r_e:
///     r = (lla(r_e) ⊟ p̂, Cᵀ v_e − v̂)  [m, m/s; north east down]      H = I      R = T Σ Tᵀ,  T = diag(Cᵀ, Cᵀ)
/// Paper 003 (11), which has one row too many: its H is I₆. What the error of r_e turns C by, v/R = 1e-5 1/s for an
/// aeroplane, is left out of T.
class PvFix final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit PvFix(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port position_, velocity_;
  Fields<6> z_;                    // x, y, z, vx, vy, vz
  std::array<int, 6> components_;  // where x y z vx vy vz stand in the channel's covariance
  int covariance_size_;
  double scale_;  // of R
};

}  // namespace binnacle::gnss_fix
