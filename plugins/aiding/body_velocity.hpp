// SPDX-License-Identifier: Apache-2.0
// A velocity over ground in body axes: a Doppler log, wheels.
#pragma once

#include <array>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "deviations.hpp"
#include "vehicle/vehicle_velocity.hpp"

namespace binnacle::aiding {

/// z = (1 + s) v_v + n, v_v = exp([ζ×]) C_bn v_n of the sensor's place; s, ζ on optional ports; of those axes that the
/// channel carries. H = (1 + s) ∂v_v/∂(port) (vehicle_velocity.hpp); ∂/∂s = v_v, by axis where s has three components.
class BodyVelocity final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit BodyVelocity(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  vehicle::VehicleVelocity velocity_;
  Port scale_;
  Fields<3> z_;
  Deviations sigma_;
  double relative_;  // 1
  int rows_ = 0;
  std::array<int, 3> axis_{};  // of each row
};

}  // namespace binnacle::aiding
