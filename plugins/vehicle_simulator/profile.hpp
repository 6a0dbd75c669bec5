// SPDX-License-Identifier: Apache-2.0
// The shape of every manoeuvre in time: a plateau of height one between two smooth ramps.
#pragma once

#include <algorithm>

namespace binnacle::vehicle_simulator {

/// S(τ) = τ³ (10 − 15 τ + 6 τ²): from 0 to 1 on [0, 1] with S' = S'' = 0 at both ends.
struct SmoothStep {
  static constexpr double value(double tau) { return tau * tau * tau * (10.0 + tau * (-15.0 + 6.0 * tau)); }
  static constexpr double slope(double tau) { return 30.0 * tau * tau * (1.0 - tau) * (1.0 - tau); }
  /// ∫₀^τ S; 1/2 at τ = 1.
  static constexpr double integral(double tau) { return tau * tau * tau * tau * (2.5 + tau * (-3.0 + tau)); }
};

/// A plateau over [0, duration]: up within `ramp` seconds, down within the last `ramp` seconds. Twice
/// continuously differentiable, zero with its first two derivatives at both ends, so manoeuvres may be joined
/// in any order. Integral over all: duration − ramp. 0 < ramp <= duration/2.
class Plateau {
 public:
  struct Value {
    double value;
    double slope;     // 1/s
    double integral;  // s, from 0
  };

  Plateau(double duration, double ramp) : duration_(duration), ramp_(ramp) {}

  /// The ramp that is used when `wanted` may be too long for the duration.
  static double fitting_ramp(double duration, double wanted) { return std::min(wanted, 0.5 * duration); }

  double area() const { return duration_ - ramp_; }

  Value at(double t) const {
    const double left = duration_ - t;
    if (t < ramp_) {
      const double tau = std::max(t / ramp_, 0.0);
      return {SmoothStep::value(tau), SmoothStep::slope(tau) / ramp_, ramp_ * SmoothStep::integral(tau)};
    }
    if (left < ramp_) {
      const double tau = std::max(left / ramp_, 0.0);
      return {SmoothStep::value(tau), -SmoothStep::slope(tau) / ramp_, area() - ramp_ * SmoothStep::integral(tau)};
    }
    return {1.0, 0.0, t - 0.5 * ramp_};
  }

 private:
  double duration_;
  double ramp_;
};

}  // namespace binnacle::vehicle_simulator
