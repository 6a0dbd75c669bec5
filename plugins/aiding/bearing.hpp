// SPDX-License-Identifier: Apache-2.0
// The direction in which an observer sees a point.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "point.hpp"

namespace binnacle::aiding {

/// With d = target − observer in north, east (down) of the observer, and C = I; or C = C_bn of an attitude, Rz(−ψ) of a heading,
/// and angles from forward and from the deck; ρ² = d_1² + d_2² and s² = ρ² + d_3² of C d:
///     azimuth   = atan2(d_2, d_1)      ∂/∂d = (−d_2, d_1, 0)/ρ²
///     elevation = atan2(−d_3, ρ)       ∂/∂d = (d_3 d_1/ρ, d_3 d_2/ρ, −ρ)/s²      ∂(C d)/∂φ = C [d×]
/// The target is a block or a point of the config; the observer is a block or, of a local target, stands in the sample. How d
/// goes by the errors of both is strapdown::navigation_way(): between local vectors I and −I.
class Bearing final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Bearing(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  void bind_places(const Binding& binding);
  void bind_axes() const;
  strapdown::Way way(const MeasurementInput& in) const;
  Eigen::Matrix3d axes(const PortValues& x) const;
  int dof() const { return target_ ? target_->port().dof() : observer_->port().dof(); }

  std::optional<SensorPlace> target_, observer_;
  Eigen::Vector3d point_;  // the target where it is no block, in the observer's axes
  Port attitude_, heading_;
  Field azimuth_, elevation_;
  std::vector<Field> place_;  // of the observer, where no block is
  double azimuth_variance_ = 0, elevation_variance_ = 0;
};

}  // namespace binnacle::aiding
