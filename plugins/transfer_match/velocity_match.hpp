// SPDX-License-Identifier: Apache-2.0
// A slave's velocity held against its master's.
#pragma once

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::transfer_match {

/// Paper 000 (2) is z_v = v_SINS − v_MINS = δv + v with δ = computed − true. Here r = z ⊟ h(x̂) = v_MINS + u − v̂_SINS and
/// H_v = +I, with u the velocity of the slave's place against the master's (the paper has none):
///   u = ω_eb × (C_M l),  ω_eb = C_S (ω − b_g) − ω_ie, l on port `lever_arm`, C_M from the sample, ω the mean driving rate
///   H_attitude = −[(C_M l)×][C_S(ω − b_g) ×]    H_gyro_bias = −[(C_M l)×] C_S    H_arm = −[ω_eb×] C_M
class VelocityMatch final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit VelocityMatch(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Eigen::Vector3d earth_rate(const SampleView& sample) const;

  /// The velocity of the slave's place against the master's, and its Jacobians.
  Result add_lever_arm(const MeasurementInput& in, MeasurementOutput& out) const;

  Port velocity_, lever_arm_, attitude_, gyro_bias_;
  Fields<3> v_, angles_;  // of the master: north, east, down; roll, pitch, yaw
  Field lat_;
  DrivingRateVector<3> omega_;
  Eigen::Vector3d variance_;  // (m/s)²
  int rows_;
};

}  // namespace binnacle::transfer_match
