// SPDX-License-Identifier: Apache-2.0
// Zero-velocity update.
#pragma once

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "spacing.hpp"

namespace binnacle::land {

/// r = 0 − v̂ [m/s, north east down], H = I: paper 001 (10), whose z is computed − true.
class Zupt final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Zupt(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port velocity_;
  Spacing spacing_;
  Eigen::Vector3d variance_;
};

}  // namespace binnacle::land
