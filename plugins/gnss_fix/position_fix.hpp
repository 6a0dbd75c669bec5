// SPDX-License-Identifier: Apache-2.0
// A position as a receiver computes it.
#pragma once

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "reported_sigma.hpp"

namespace binnacle::gnss_fix {

/// r = z ⊟ p̂ [m, north east down, by the radii at p̂], H = I (paper 003 (11), whose I₆ is this and VelocityFix).
/// With a bias, 3 [m, north east down]: z = p ⊞ (b + v), r = (z ⊟ p̂) − b̂, H = I in b as well.
class PositionFix final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit PositionFix(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port position_;
  Port bias_;    // open: none
  Fields<3> z_;  // latitude, longitude, height
  ReportedSigma sigma_;
};

}  // namespace binnacle::gnss_fix
