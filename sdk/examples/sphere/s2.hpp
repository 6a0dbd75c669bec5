// SPDX-License-Identifier: Apache-2.0
// The unit sphere S²: directions, with errors in the plane that touches it.
#pragma once

#include <Eigen/Dense>

#include <cmath>

/// A direction x, two unit vectors B = [b1, b2] that span the plane normal to it, and δ the coordinates of an error in them:
///
///     x ⊞ δ = cos θ x + (sin θ/θ) B δ          along a great circle, θ = |δ| radians
///     y ⊟ x = (θ/sin θ) Bᵀ y,  θ = ∠(x, y) < π
///
/// C. Hertzberg, R. Wagner, U. Frese, L. Schröder, "Integrating generic sensor fusion algorithms with sound state
/// representations through encapsulation of manifolds", Information Fusion 14(1), 2013, section 3.
///
/// No B(x) is continuous on the whole sphere. So B is no function of x here: it is kept with x, and goes along with it.
namespace s2 {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Basis = Eigen::Matrix<double, 3, 2>;
/// [b1, b2, x], orthonormal.
using Frame = Eigen::Matrix3d;

inline Basis axes(const Frame& frame) { return frame.leftCols<2>(); }
inline Vector3 direction(const Frame& frame) { return frame.col(2); }

/// Some axes at x: T. Duff and others, "Building an orthonormal basis, revisited", JCGT 6(1), 2017.
inline Frame frame_at(const Vector3& x) {
  const double sign = std::copysign(1.0, x[2]);
  const double a = -1 / (sign + x[2]), b = x[0] * x[1] * a;
  Frame frame;
  frame.col(0) << 1 + sign * x[0] * x[0] * a, sign * b, -sign * x[0];
  frame.col(1) << b, sign + x[1] * x[1] * a, -x[1];
  frame.col(2) = x;
  return frame;
}

/// Without what rounding has done to it (Gram and Schmidt, x first).
inline Frame orthonormal(const Frame& frame) {
  const Vector3 x = frame.col(2).normalized();
  const Vector3 first = (frame.col(0) - x.dot(frame.col(0)) * x).normalized();
  const Vector3 second = frame.col(1) - x.dot(frame.col(1)) * x - first.dot(frame.col(1)) * first;
  Frame clean;
  clean << first, second.normalized(), x;
  return clean;
}

/// sin θ/θ.
inline double sinc(double theta) { return theta < 1e-4 ? 1 - theta * theta / 6 : std::sin(theta) / theta; }
/// (1 − cos θ)/θ².
inline double versine(double theta) { return sinc(theta / 2) * sinc(theta / 2) / 2; }
/// (1 − sin θ/θ)/θ².
inline double sinc_fall(double theta) {
  return theta < 1e-2 ? (1 - theta * theta / 20) / 6 : (1 - sinc(theta)) / (theta * theta);
}

/// x ⊞ δ, with the axes carried along the great circle (parallel transport).
inline Frame plus(const Frame& frame, const Vector2& delta) {
  const double theta = delta.norm();
  const Vector3 u = axes(frame) * delta, x = direction(frame);
  Frame moved = frame;
  moved.leftCols<2>() -= (versine(theta) * u + sinc(theta) * x) * delta.transpose();
  moved.col(2) = std::cos(theta) * x + sinc(theta) * u;
  return orthonormal(moved);
}

/// y ⊟ x. Of opposite directions, where any great circle would do, the one along the first axis.
inline Vector2 minus(const Vector3& y, const Frame& frame) {
  const Vector2 p = axes(frame).transpose() * y;  // sin θ in its direction
  const double sine = p.norm(), cosine = direction(frame).dot(y), theta = std::atan2(sine, cosine);
  if (sine > 1e-12) return theta / sine * p;
  return cosine > 0 ? p : Vector2(theta, 0);
}

/// ∂(x ⊞ δ)/∂δ of the direction, 3×2: along the great circle it turns, across it is shorter by sin θ/θ.
///
///     D = −(sin θ/θ) x δᵀ + B ((sin θ/θ) I + (cos θ − sin θ/θ)/θ² δ δᵀ)
inline Basis plus_jacobian(const Frame& frame, const Vector2& delta) {
  const double theta = delta.norm(), s = sinc(theta), c = sinc_fall(theta) - versine(theta);
  return -s * direction(frame) * delta.transpose() +
         axes(frame) * (s * Eigen::Matrix2d::Identity() + c * delta * delta.transpose());
}

/// G of a reset, in the axes that were carried along: 1 along the great circle, sin θ/θ across it.
///
///     G = B⁺ᵀ D = (sin θ/θ) I + (1 − sin θ/θ)/θ² δ δᵀ
inline Eigen::Matrix2d reset_jacobian(const Vector2& delta) {
  const double theta = delta.norm();
  return sinc(theta) * Eigen::Matrix2d::Identity() + sinc_fall(theta) * delta * delta.transpose();
}

/// ∂((y ⊞ ε) ⊟ x)/∂ε at ε = 0.
inline Eigen::Matrix2d minus_jacobian(const Frame& y, const Frame& x) {
  return (axes(y).transpose() * plus_jacobian(x, minus(direction(y), x))).inverse();
}

}  // namespace s2
