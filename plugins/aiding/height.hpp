// SPDX-License-Identifier: Apache-2.0
// A height alone: a barometer, a tide gauge, a map.
#pragma once

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "deviations.hpp"

namespace binnacle::aiding {

/// z = h + b + s (h − h₀) + v [m, up]; h of a geodetic position, or −down of a local one; b, s on optional ports.
///     ∂/∂down = −(1 + s)     ∂/∂b = 1     ∂/∂s = h − h₀
class Height final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit Height(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  Port position_, bias_, scale_;
  Field height_;
  Deviations sigma_;
  double reference_;  // m
  double upward_;     // of the third stored component: 1 of a geodetic position, −1 of a local one
};

}  // namespace binnacle::aiding
