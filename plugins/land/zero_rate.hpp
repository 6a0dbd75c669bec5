// SPDX-License-Identifier: Apache-2.0
// Zero angular rate: what the gyroscopes show of a body at rest is the earth's rate and their bias.
#pragma once

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "spacing.hpp"

namespace binnacle::land {

/// h = b_g + C_bn ω_ie_n [rad/s, body axes], r = ω_measured − h. Without position and attitude the earth's rate is left
/// out. H = +∂h/∂δ: I for b_g, C_bn [ω_ie×] for φ, C_bn ∂ω_ie/∂N for the position's first component.
class ZeroRate final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit ZeroRate(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port gyro_bias_, attitude_, position_;
  Fields<3> omega_;
  Spacing spacing_;
  Eigen::Vector3d variance_;
  bool has_earth_;
};

}  // namespace binnacle::land
