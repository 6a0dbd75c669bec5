// SPDX-License-Identifier: Apache-2.0
// Differences of distances to points that are known: times of arrival without a clock in common with the sender.
#pragma once

#include <array>
#include <optional>

#include "anchors.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "point.hpp"

namespace binnacle::aiding {

/// A row per pair of anchors (a, c), c the reference. With u_a = (r − r_a)/|r − r_a|, and b as in Range:
///     z = (|r − r_a| + b_a + v_a) − (|r − r_c| + b_c + v_c)      ∂z/∂r = (u_a − u_c)ᵀ
/// Each anchor's time of arrival has one noise, which all rows that it is in share: R = D diag(σ²) Dᵀ, D the rows' +1 and −1.
/// A row that closes a ring of pairs is a sum of others and brings nothing: it is left out, and so R is regular.
class RangeDifference final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit RangeDifference(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  static constexpr int limit = 32;  // rows of a sample
  /// What one row takes from an anchor.
  struct Arrival {
    AnchorSight anchor;
    double range = 0, variance = 0;  // m with biases, m²
    Eigen::RowVector3d by_error;
  };
  struct Pair {
    Arrival of, reference;
  };
  using Pairs = std::array<Pair, limit>;

  bool arrive(const MeasurementInput& in, const strapdown::CartesianPlace& place, Arrival& arrival) const;
  std::optional<Pair> pair(const MeasurementInput& in, const strapdown::CartesianPlace& place, int row) const;

  SensorPlace sensor_;
  Anchors anchors_;
  Port bias_;
  RowField difference_, anchor_, reference_;
  std::optional<std::int64_t> fixed_reference_;
  double variance_ = 0;  // m², of a time of arrival; 0: none is given
  int most_;
};

}  // namespace binnacle::aiding
