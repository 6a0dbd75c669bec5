// SPDX-License-Identifier: Apache-2.0
// What attitude algorithms make of a coning motion, in closed form and extended precision. Written from the motion and
// paper 002's coefficients alone: nothing here is the code under test.
#pragma once

#include <array>
#include <stdexcept>

#include <boost/multiprecision/cpp_bin_float.hpp>

namespace binnacle::test {

/// Fifty decimal digits.
using Real = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>, boost::multiprecision::et_off>;
using RealVector = std::array<Real, 3>;

inline RealVector cross(const RealVector& a, const RealVector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Paper 002, equations (2), (3), (9): k_ij of θ_i × θ_j.
inline Real coning_coefficient(int samples, int i, int j) {
  const auto key = 100 * samples + 10 * i + j;
  switch (key) {
    case 212: return Real(2) / 3;
    case 313: return Real(45) / 100;
    case 312:
    case 323: return Real(675) / 1000;
    case 412: return Real(-92) / 105;
    case 413: return Real(92) / 105;
    case 414: return Real(54) / 105;
    case 423: return Real(306) / 105;
    case 424:
    case 434: return Real(0);
    default: throw std::logic_error("no such pair");
  }
}

/// Error of one update about the cone's axis over ε², for a small cone, by lag sums S_l = Σ_{j−i=l} k_ij, computed minus true:
///     −x/2 + ½ sin x + 2 (1 − cos λ) Σ S_l sin lλ,     x = W h, λ = x/N
inline Real lag_expression(int samples, const Real& x) {
  const Real lag = x / samples;
  Real error = (sin(x) - x) / 2;
  for (int i = 1; i <= samples; ++i)
    for (int j = i + 1; j <= samples; ++j)
      error += 2 * (1 - cos(lag)) * coning_coefficient(samples, i, j) * sin((j - i) * lag);
  return error;
}

/// The drift of n updates about the cone's axis [rad], computed minus true, for a cone of any size ε. In axes that turn with
/// the cone, r = exp(x e_x), all updates are the same q̂, so n of them make (q̂ r)ⁿ r⁻ⁿ. The true q r turns by x exactly, so
/// the drift is n times what q̂ r turns beyond that.
inline Real secular_drift(int samples, const Real& epsilon, const Real& x, const Real& n) {
  const Real lag = x / samples, swing = 2 * sin(epsilon) * sin(lag / 2);
  std::array<RealVector, 4> theta;
  for (int i = 0; i < samples; ++i) {
    const Real middle = (i + Real(1) / 2) * lag;
    const Real half = sin(epsilon / 2);
    theta[static_cast<std::size_t>(i)] = {-2 * half * half * lag, -swing * sin(middle), swing * cos(middle)};
  }
  RealVector phi{};
  for (int i = 0; i < samples; ++i) {
    for (std::size_t c = 0; c < 3; ++c) phi[c] += theta[static_cast<std::size_t>(i)][c];
    for (int j = i + 1; j < samples; ++j) {
      const RealVector product = cross(theta[static_cast<std::size_t>(i)], theta[static_cast<std::size_t>(j)]);
      for (std::size_t c = 0; c < 3; ++c) phi[c] += coning_coefficient(samples, i + 1, j + 1) * product[c];
    }
  }
  const Real angle = sqrt(phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2]);
  const Real w = cos(angle / 2), s = sin(angle / 2) / angle;
  // q̂ r, r = (cos x/2, sin x/2, 0, 0)
  const Real c = cos(x / 2), t = sin(x / 2);
  const Real scalar = w * c - s * phi[0] * t;
  const RealVector vector{w * t + s * phi[0] * c, s * phi[1] * c + s * phi[2] * t, s * phi[2] * c - s * phi[1] * t};
  const Real sine = sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
  return n * (2 * atan2(sine, scalar) - x);
}

}  // namespace binnacle::test
