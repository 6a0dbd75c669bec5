// SPDX-License-Identifier: Apache-2.0
// Non-holonomic constraint: wheels roll forward, and neither sideways nor off the road.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"
#include "spacing.hpp"
#include "vehicle_velocity.hpp"

namespace binnacle::land {

/// r = 0 − (v_v)_yz [m/s], H = +∂(v_v)_yz/∂δ: paper 001 (4), and (9) when the misalignment is plugged in. (9) prints
/// δζ = true − estimate and its other errors as computed − true; here all of them are true − estimate.
class Nhc final : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Nhc(const Binding& binding);

  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }
  void start(std::byte* memory) const override { spacing_.start(memory); }
  Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                   const legacy::Context& context, std::byte* memory, legacy::Linearization& out) const override;

 private:
  VehicleVelocity velocity_;
  Spacing spacing_;
  MeasurementDeclaration declaration_;
  Eigen::Vector2d sigma_;                // m/s: y, z
  double angle_;                         // rad
  double slip_;                          // rad per m/s²
  double min_speed_;                     // m/s
  std::optional<double> max_turn_rate_;  // rad/s
  int first_, rows_;                     // of the rows y, z
};

}  // namespace binnacle::land
