// SPDX-License-Identifier: Apache-2.0
// A vehicle on roads is level across, in the mean.
#pragma once

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "spacing.hpp"

namespace binnacle::land {

/// h = roll(C_nb) [rad], r = 0 − h. H = +∂h/∂φ = (cos ψ, sin ψ, 0) / cos θ, from C_true = (I + [φ]×) C and
/// roll = atan2(C_32, C_33).
class Level final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Level(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port attitude_;
  Spacing spacing_;
  double variance_;
};

}  // namespace binnacle::land
