// SPDX-License-Identifier: Apache-2.0
// Non-holonomic constraint: wheels roll forward, and neither sideways nor off the road.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "spacing.hpp"
#include "vehicle_ports.hpp"

namespace binnacle::land {

/// r = 0 − h [m/s], h = (v_v)_yz, H = +∂h/∂δ: paper 001 (4), and (9) when the misalignment is plugged in. (9) prints
/// δζ = true − estimate and its other errors as computed − true; here all of them are true − estimate.
/// With compliance κ [rad per m/s²], of springs and tyres under the sample's mean specific force f: h_y = v_y − κ_y f_y v_x
/// and h_z = v_z − κ_z f_x v_x, so ∂h/∂κ = −f v_x.
class Nhc final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Nhc(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Result vary(const MeasurementInput& in, double speed, Eigen::Vector2d& variance) const;

  vehicle::VehicleVelocity velocity_;
  Port compliance_;
  Spacing spacing_;
  DrivingRateVector<3> omega_;
  DrivingRate force_;
  Several<Field, 2> forces_;             // y: to the right, z: ahead
  Eigen::Vector2d sigma_;                // m/s: y, z
  double angle_;                         // rad
  double slip_;                          // rad per m/s²
  double turn_;                          // m
  double lateral_;                       // s
  double min_speed_;                     // m/s
  std::optional<double> max_turn_rate_;  // rad/s
  int first_, rows_;                     // of the rows y, z
};

}  // namespace binnacle::land
