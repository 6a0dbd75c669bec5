// SPDX-License-Identifier: Apache-2.0
// The heading of a line on the body: two antennas, a compass.
#pragma once

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "deviations.hpp"

namespace binnacle::aiding {

/// With u = C_nb l, l the baseline in body axes, ρ² = u_n² + u_e², C_true = (I + [φ×]) Ĉ:
///     z = atan2(u_e, u_n) + b − D + v      ∂/∂φ = (−u_n u_d, −u_e u_d, ρ²)/ρ²      ∂/∂b = 1
/// D is the declination, 0 of true headings; b stands on an optional port. r is taken within half a turn.
class Heading final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Heading(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port attitude_, bias_;
  Field heading_;
  Deviations sigma_;
  double declination_;          // rad
  double least_;                // ρ/|l|, below which there is no heading
  Eigen::Vector3d baseline_b_;  // unit vector
};

}  // namespace binnacle::aiding
