// SPDX-License-Identifier: Apache-2.0
// The rows of an observation channel: what is measured, and what a channel may give of the satellite itself.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "binnacle/binding.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"
#include "gnss/satellite.hpp"

namespace binnacle::gnss {

/// Where the fields of a row are. Satellites are *given* where the channel carries their position; then no ephemeris is
/// needed.
class ObservationRows {
 public:
  /// The fields of observation_fields(), and no other.
  ObservationRows();
  /// Of a component whose spec has observation_fields() and given_fields(). Throws ComponentError where only some of the
  /// fields that belong together are there.
  explicit ObservationRows(const Binding& binding);

  bool are_given() const noexcept { return position_[0].is_bound(); }
  bool has_velocity() const noexcept { return velocity_[0].is_bound(); }
  bool has_system() const noexcept { return system_.is_bound(); }
  bool has_clock() const noexcept { return clock_.is_bound(); }
  bool has_clock_drift() const noexcept { return clock_drift_.is_bound(); }
  bool has_cn0() const noexcept { return cn0_.is_bound(); }
  bool has_variance() const noexcept {
    return range_sigma_.is_bound() || range_variance_.is_bound() || rate_sigma_.is_bound() || rate_variance_.is_bound();
  }

  double pseudorange(const SampleView& sample, int row) const { return sample(row, pseudorange_); }
  double range_rate(const SampleView& sample, int row) const { return sample(row, range_rate_); }
  double cn0(const SampleView& sample, int row) const { return sample(row, cn0_); }
  /// 0: none that can be used.
  SatelliteKey satellite(const SampleView& sample, int row) const;
  /// Of the satellite: field `system`, else the key over 100, as SatelliteKey has it.
  std::int64_t system(const SampleView& sample, int row, SatelliteKey key) const;
  /// m, m/s: NaN where the channel has none.
  Eigen::Vector3d position(const SampleView& sample, int row) const { return vector(sample, row, position_); }
  Eigen::Vector3d velocity(const SampleView& sample, int row) const { return vector(sample, row, velocity_); }
  double clock(const SampleView& sample, int row) const { return sample(row, clock_); }
  double clock_drift(const SampleView& sample, int row) const { return sample(row, clock_drift_); }
  /// m², m²/s²; NaN where the row gives none.
  double range_variance(const SampleView& sample, int row) const {
    return variance(sample, row, range_sigma_, range_variance_);
  }
  double rate_variance(const SampleView& sample, int row) const {
    return variance(sample, row, rate_sigma_, rate_variance_);
  }

 private:
  static Eigen::Vector3d vector(const SampleView& sample, int row, const RowField (&fields)[3]) {
    return {sample(row, fields[0]), sample(row, fields[1]), sample(row, fields[2])};
  }
  static double variance(const SampleView& sample, int row, RowField sigma, RowField variance);

  RowField satellite_, pseudorange_, range_rate_, cn0_;
  RowField system_, clock_, clock_drift_;
  RowField range_sigma_, range_variance_, rate_sigma_, rate_variance_;
  RowField position_[3], velocity_[3];
};

/// What a channel may give besides observation_fields(), all optional and per row.
std::vector<FieldSpec> given_fields();

}  // namespace binnacle::gnss
