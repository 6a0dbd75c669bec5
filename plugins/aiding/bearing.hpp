// SPDX-License-Identifier: Apache-2.0
// The direction in which an observer sees a point.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::aiding {

/// With d = target − observer in local axes north, east (down), ρ² = d_n² + d_e² and s² = ρ² + d_d²:
///     azimuth   = atan2(d_e, d_n)      ∂/∂d = (−d_e, d_n, 0)/ρ²
///     elevation = atan2(−d_d, ρ)       ∂/∂d = (d_d d_n/ρ, d_d d_e/ρ, −ρ)/s²
/// The observer is a block or stands in the sample; H of a block that is the observer is −H of the target.
class Bearing final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Bearing(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port target_, observer_;
  Field azimuth_, elevation_;
  std::vector<Field> place_;  // of the observer, where no block is
  double azimuth_variance_ = 0, elevation_variance_ = 0;
};

}  // namespace binnacle::aiding
