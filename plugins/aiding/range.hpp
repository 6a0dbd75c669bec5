// SPDX-License-Identifier: Apache-2.0
// Distances to points that are known.
#pragma once

#include "anchors.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "point.hpp"

namespace binnacle::aiding {

/// A row per anchor. With d = r − r_a in Cartesian axes (ECEF, or those of a local vector) and u = d/|d|:
///     z = |d| + b + b_a + v      ∂z/∂r = uᵀ      ∂z/∂b = 1      R = σ² + (relative z)²
/// b: port `bias`; b_a: of the config. ∂r/∂δ is C_en for a geodetic place.
class Range final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Range(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  /// Of a row [m²]; not positive: it has none.
  double variance(const SampleView& sample, int row, const AnchorSight& anchor) const;

  SensorPlace sensor_;
  Anchors anchors_;
  Port bias_;
  RowField range_, anchor_, sd_of_row_, variance_of_row_;
  double variance_ = 0;  // m²; 0: none is given
  double relative_;
  int most_;
};

}  // namespace binnacle::aiding
