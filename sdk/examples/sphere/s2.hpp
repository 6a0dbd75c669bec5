// SPDX-License-Identifier: Apache-2.0
// The unit sphere S²: directions, with errors in the plane that touches it.
#pragma once

#include <Eigen/Dense>

#include <cmath>

/// x is a unit vector, B(x) two unit vectors that span the plane normal to it, and δ the coordinates of an error in them:
///
///     x ⊞ δ = cos|δ| x + sin|δ|/|δ| B(x) δ          along a great circle, |δ| radians
///     y ⊟ x = θ/sin θ B(x)ᵀ y,  θ = ∠(x, y) < π
///
/// C. Hertzberg, R. Wagner, U. Frese, L. Schröder, "Integrating generic sensor fusion algorithms with sound state
/// representations through encapsulation of manifolds", Information Fusion 14(1), 2013, section 3.
///
/// No B is continuous on the whole sphere. It need not be: whatever moves x from one place to another has a Jacobian that
/// leads from the axes at the one to those at the other.
namespace s2 {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Basis = Eigen::Matrix<double, 3, 2>;

/// T. Duff and others, "Building an orthonormal basis, revisited", JCGT 6(1), 2017: exact everywhere, with a jump at z = 0.
inline Basis basis(const Vector3& x) {
  const double sign = std::copysign(1.0, x[2]);
  const double a = -1 / (sign + x[2]), b = x[0] * x[1] * a;
  Basis B;
  B.col(0) << 1 + sign * x[0] * x[0] * a, sign * b, -sign * x[0];
  B.col(1) << b, sign + x[1] * x[1] * a, -x[1];
  return B;
}

/// sin θ/θ.
inline double sinc(double theta) { return theta < 1e-4 ? 1 - theta * theta / 6 : std::sin(theta) / theta; }

inline Vector3 plus(const Vector3& x, const Vector2& delta) {
  const double theta = delta.norm();
  return (std::cos(theta) * x + sinc(theta) * basis(x) * delta).normalized();
}

/// Of opposite directions, where any great circle would do, the one along the first axis.
inline Vector2 minus(const Vector3& y, const Vector3& x) {
  const Vector2 p = basis(x).transpose() * y;  // sin θ in its direction
  const double sine = p.norm(), theta = std::atan2(sine, x.dot(y));
  if (sine > 1e-12) return theta / sine * p;
  return x.dot(y) > 0 ? p : Vector2(theta, 0);
}

/// ∂(x ⊞ δ)/∂δ, 3×2: along the great circle it turns, across it is shorter by sin θ/θ.
///
///     D = −sin θ/θ x δᵀ + B ((sin θ/θ) I + (cos θ − sin θ/θ)/θ² δ δᵀ)
inline Basis plus_jacobian(const Vector3& x, const Vector2& delta) {
  const double theta = delta.norm(), s = sinc(theta);
  const double c = theta < 1e-3 ? -1.0 / 3 + theta * theta / 30 : (std::cos(theta) - s) / (theta * theta);
  return -s * x * delta.transpose() + basis(x) * (s * Eigen::Matrix2d::Identity() + c * delta * delta.transpose());
}

/// G of a reset: the remaining error in the axes at x ⊞ δ, δ_new = B(x ⊞ δ)ᵀ D (δ_old − δ) to first order.
inline Eigen::Matrix2d reset_jacobian(const Vector3& x, const Vector2& delta) {
  return basis(plus(x, delta)).transpose() * plus_jacobian(x, delta);
}

/// ∂((y ⊞ ε) ⊟ x)/∂ε at ε = 0: the inverse of what reset_jacobian makes of δ = y ⊟ x.
inline Eigen::Matrix2d minus_jacobian(const Vector3& y, const Vector3& x) {
  return (basis(y).transpose() * plus_jacobian(x, minus(y, x))).inverse();
}

}  // namespace s2
