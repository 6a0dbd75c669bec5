// SPDX-License-Identifier: Apache-2.0
// Trigonometric quotients of a rotation angle that stay accurate down to zero.
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace binnacle::strapdown::detail {

// Below half a radian the power series in θ², cut where its remainder is below 1e-16 of its value; above, closed form.
inline constexpr double small_angle_squared = 0.25;

/// Σ coefficient[i] x^i, by Horner.
template <int N>
constexpr double polynomial(const double (&coefficient)[N], double x) {
  double sum = coefficient[N - 1];
  for (int i = N - 2; i >= 0; --i) {
    sum = coefficient[i] + x * sum;
  }
  return sum;
}

/// (1 − cos θ)/θ²
inline double one_minus_cos(double theta_squared) {
  if (theta_squared < small_angle_squared) {
    constexpr double c[] = {1.0 / 2, -1.0 / 24, 1.0 / 720, -1.0 / 40320, 1.0 / 3628800, -1.0 / 479001600};
    return polynomial(c, theta_squared);
  }
  return (1.0 - std::cos(std::sqrt(theta_squared))) / theta_squared;
}

/// (θ − sin θ)/θ³
inline double angle_minus_sin(double theta_squared) {
  if (theta_squared < small_angle_squared) {
    constexpr double c[] = {1.0 / 6, -1.0 / 120, 1.0 / 5040, -1.0 / 362880, 1.0 / 39916800, -1.0 / 6227020800.0};
    return polynomial(c, theta_squared);
  }
  const double theta = std::sqrt(theta_squared);
  return (theta - std::sin(theta)) / (theta * theta_squared);
}

/// (cos θ − 1 + θ²/2)/θ⁴
inline double cos_minus_parabola(double theta_squared) {
  if (theta_squared < small_angle_squared) {
    constexpr double c[] = {1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800, 1.0 / 479001600, -1.0 / 87178291200.0};
    return polynomial(c, theta_squared);
  }
  return (std::cos(std::sqrt(theta_squared)) - 1.0 + 0.5 * theta_squared) / (theta_squared * theta_squared);
}

/// Unit quaternion of a rotation vector: (cos θ/2, (sin θ/2)/θ · vector).
inline Eigen::Vector4d exp(const Eigen::Vector3d& v) {
  const double theta_squared = v.squaredNorm();
  double w = 0.0, scale = 0.0;
  if (theta_squared < small_angle_squared) {
    const double x = 0.25 * theta_squared;  // (θ/2)²
    constexpr double cosine[] = {1.0, -1.0 / 2, 1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800};
    constexpr double sinc[] = {1.0, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880, -1.0 / 39916800};
    w = polynomial(cosine, x);
    scale = 0.5 * polynomial(sinc, x);
  } else {
    const double theta = std::sqrt(theta_squared);
    w = std::cos(0.5 * theta);
    scale = std::sin(0.5 * theta) / theta;
  }
  return {w, scale * v[0], scale * v[1], scale * v[2]};
}

}  // namespace binnacle::strapdown::detail
