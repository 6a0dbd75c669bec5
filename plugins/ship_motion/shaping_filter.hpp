// SPDX-License-Identifier: Apache-2.0
// The shaping filter of order 2 or 4: dynamics, steady state, autocovariance, spectrum.
#pragma once

#include <Eigen/Core>

namespace binnacle::ship_motion {

/// θ̈ + 2ζ₁ω₁θ̇ + ω₁²θ = s; of order 2 s is white noise, of order 4 s̈ + 2ζ₂ω₂ṡ + ω₂²s = w is.
struct ShapingFilter {
  Eigen::VectorXd omega;  // rad/s
  Eigen::VectorXd zeta;   // 1
  double sigma = 0;       // standard deviation of θ in the steady state

  Eigen::Index order() const { return 2 * omega.size(); }
  /// F of θ, θ̇ and, of order 4, s, ṡ.
  Eigen::MatrixXd dynamics() const;
  /// Covariance of the states in the steady state, from F P + P Fᵀ + q g gᵀ = 0.
  Eigen::MatrixXd steady_covariance() const;
  /// q, the power spectral density of w.
  double noise_density() const;
  /// E[θ(t) θ(t + kT)] for k = 0 … count − 1.
  Eigen::VectorXd autocovariance(double interval, Eigen::Index count) const;
  /// One-sided densities at frequencies nu [rad/s]: the integral over 0 … ∞ is σ².
  Eigen::VectorXd spectrum(const Eigen::VectorXd& nu) const;
  /// Where the spectrum is greatest [rad/s]; 0 where it only falls.
  double peak() const;
};

}  // namespace binnacle::ship_motion
