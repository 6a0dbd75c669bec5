// SPDX-License-Identifier: Apache-2.0
// A wheel sensor: speed along the vehicle's x axis.
#pragma once

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "vehicle_ports.hpp"

namespace binnacle::land {

/// h = (1 + s) (v_v)_x [m/s], r = z − h, H = +∂h/∂δ; s on the optional port `scale`.
class Odometer final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Odometer(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  vehicle::VehicleVelocity velocity_;
  Port scale_;
  Field speed_;
  double sigma_;      // m/s
  double relative_;   // 1
  double min_speed_;  // m/s
};

}  // namespace binnacle::land
