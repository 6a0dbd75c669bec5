// SPDX-License-Identifier: Apache-2.0
// The direction of the horizontal velocity.
#pragma once

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "deviations.hpp"

namespace binnacle::aiding {

/// z = atan2(v_e, v_n) + n, V² = v_n² + v_e²:   ∂/∂v = (−v_e, v_n, 0)/V²
/// Variance: sigma² + (velocity_sigma/V)², V of the estimate. r is taken within half a turn.
class Course final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Course(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port velocity_;
  Field course_;
  Deviations sigma_;
  double velocity_sigma_, min_speed_;  // m/s
};

}  // namespace binnacle::aiding
