// SPDX-License-Identifier: Apache-2.0
// A velocity as a receiver computes it.
#pragma once

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "reported_sigma.hpp"

namespace binnacle::gnss_fix {

/// r = z − v̂ [m/s, north east down], H = I (paper 003 (11), whose I₆ is PositionFix and this).
class VelocityFix final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit VelocityFix(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port velocity_;
  Fields<3> z_;  // north, east, down
  ReportedSigma sigma_;
};

}  // namespace binnacle::gnss_fix
