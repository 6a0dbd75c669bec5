// SPDX-License-Identifier: Apache-2.0
// A wheel sensor: speed along the vehicle's x axis.
#pragma once

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"
#include "vehicle_velocity.hpp"

namespace binnacle::land {

/// h = (1 + s) (v_v)_x [m/s], r = z − h, H = +∂h/∂δ; s on the optional port `scale`.
class Odometer final : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Odometer(const Binding& binding);

  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }
  Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const legacy::Context& context, std::byte* memory, legacy::Linearization& out) const override;

 private:
  VehicleVelocity velocity_;
  MeasurementDeclaration declaration_;
  double sigma_;      // m/s
  double relative_;   // 1
  double min_speed_;  // m/s
  bool has_scale_;
};

}  // namespace binnacle::land
