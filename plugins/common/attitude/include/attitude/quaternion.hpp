// SPDX-License-Identifier: Apache-2.0
// Quaternions of rotation vectors, exact or by truncated series, and the update of an attitude by them.
#pragma once

#include <cmath>
#include <type_traits>

#include <Eigen/Core>

#include "attitude/rotation_vector.hpp"

namespace binnacle::attitude {

/// (w, x, y, z)
template <class Scalar>
using Vector4 = Eigen::Matrix<Scalar, 4, 1>;

/// How many terms of cos(φ/2) and of sin(φ/2) are kept; zero: all of them. Paper 002, table 1, has an "order" of
/// truncation, which can be read in two ways:
///   powers up to p of φ:   order 2: 1 − φ²/8 and φ/2;   4: φ⁴ and φ³;   5: φ⁴ and φ⁵
///   terms of each series:  order 2: 1 − φ²/8 and φ/2 − φ³/48;  and so on
struct Truncation {
  int cosine_terms = 0, sine_terms = 0;

  static constexpr Truncation exact() { return {}; }
  static constexpr Truncation at_power(int p) { return {p / 2 + 1, (p + 1) / 2}; }
  static constexpr Truncation after_terms(int n) { return {n, n}; }
  constexpr bool is_exact() const { return cosine_terms == 0; }
};

namespace detail {

/// Σ_{k<terms} (−x)^k / ((first+1)(first+2) … (first+2k)), by Horner: cos √x for first = 0, sin √x / √x for first = 1.
template <class Scalar, int first>
Scalar alternating(const Scalar& x, int terms) {
  constexpr auto divisor = [](int k) { return (2 * k - 1 + first) * (2 * k + first); };
  Scalar sum(1);
  if constexpr (std::is_floating_point_v<Scalar>) {
    constexpr Scalar factor[] = {0,
                                 Scalar(1) / divisor(1),
                                 Scalar(1) / divisor(2),
                                 Scalar(1) / divisor(3),
                                 Scalar(1) / divisor(4),
                                 Scalar(1) / divisor(5),
                                 Scalar(1) / divisor(6)};
    for (int k = terms - 1; k > 0; --k) sum = Scalar(1) - sum * (x * factor[k]);
  } else {
    for (int k = terms - 1; k > 0; --k) sum = Scalar(1) - sum * x / Scalar(divisor(k));
  }
  return sum;
}

template <class Scalar>
constexpr int terms_below_half = std::is_same_v<Scalar, float>    ? 4
                                 : std::is_same_v<Scalar, double> ? 7
                                                                  : 0;

}  // namespace detail

/// (cos φ/2, (φ vector/φ) sin φ/2), equation (6) with the root that φ₀ lacks there. Truncated it is no unit quaternion.
template <class Scalar>
Vector4<Scalar> quaternion(const Vector3<Scalar>& phi, Truncation truncation = {}) {
  using std::cos, std::sin, std::sqrt;
  const Scalar x = phi.squaredNorm() / Scalar(4);  // (φ/2)²
  Scalar cosine(1), sinc(1);
  if (truncation.is_exact() && x < Scalar(0.0625))
    truncation = Truncation::after_terms(detail::terms_below_half<Scalar>);
  if (!truncation.is_exact()) {
    cosine = detail::alternating<Scalar, 0>(x, truncation.cosine_terms);
    sinc = detail::alternating<Scalar, 1>(x, truncation.sine_terms);
  } else if (x > Scalar(0)) {
    const Scalar half = sqrt(x);
    cosine = cos(half);
    sinc = sin(half) / half;
  }
  const Scalar s = sinc / Scalar(2);
  return {cosine, s * phi[0], s * phi[1], s * phi[2]};
}

/// q ⊗ p (Hamilton's product).
template <class Scalar>
Vector4<Scalar> product(const Vector4<Scalar>& q, const Vector4<Scalar>& p) {
  return {q[0] * p[0] - q[1] * p[1] - q[2] * p[2] - q[3] * p[3], q[0] * p[1] + q[1] * p[0] + q[2] * p[3] - q[3] * p[2],
          q[0] * p[2] - q[1] * p[3] + q[2] * p[0] + q[3] * p[1], q[0] * p[3] + q[1] * p[2] - q[2] * p[1] + q[3] * p[0]};
}

template <class Scalar>
Vector4<Scalar> normalised(const Vector4<Scalar>& q) {
  using std::sqrt;
  return q * (Scalar(1) / sqrt(q.squaredNorm()));
}

/// Body to navigation, after the body turned by φ: q ⊗ q(φ).
template <class Scalar>
Vector4<Scalar> updated(const Vector4<Scalar>& q, const Vector3<Scalar>& phi, Truncation truncation) {
  return normalised(product(q, quaternion(phi, truncation)));
}

/// The same after the axes of navigation turned by `frame`, too: q(−frame) ⊗ q ⊗ q(φ).
template <class Scalar>
Vector4<Scalar> updated(const Vector3<Scalar>& frame, const Vector4<Scalar>& q, const Vector3<Scalar>& phi,
                        Truncation truncation) {
  const Vector3<Scalar> back = -frame;
  return updated(product(quaternion(back), q), phi, truncation);
}

}  // namespace binnacle::attitude
