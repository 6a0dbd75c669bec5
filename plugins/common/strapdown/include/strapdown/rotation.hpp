// SPDX-License-Identifier: Apache-2.0
// Rotations in three dimensions: quaternions, direction cosine matrices, Euler angles, rotation vectors.
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace binnacle::strapdown {

// Conventions.
// A quaternion is an Eigen::Vector4d (w, x, y, z). q_nb and C_nb both take body components to navigation
// components: v_n = C_nb v_b = q_nb ⊗ (0, v_b) ⊗ q_nb*, and C(q ⊗ p) = C(q) C(p).
// A rotation vector is axis times angle (rad); quaternion_exp(phi) belongs to the matrix exp([phi×]).
// q and −q are the same attitude; no function here changes the sign of a quaternion unless it says so.

/// [v×]: skew(v) * u == v.cross(u).
inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m(0, 0) = m(1, 1) = m(2, 2) = 0.0;
  m(2, 1) = v[0], m(1, 2) = -v[0];
  m(0, 2) = v[1], m(2, 0) = -v[1];
  m(1, 0) = v[2], m(0, 1) = -v[2];
  return m;
}

/// q ⊗ p (Hamilton's product).
inline Eigen::Vector4d quaternion_product(const Eigen::Vector4d& q, const Eigen::Vector4d& p) {
  return {q[0] * p[0] - q[1] * p[1] - q[2] * p[2] - q[3] * p[3], q[0] * p[1] + q[1] * p[0] + q[2] * p[3] - q[3] * p[2],
          q[0] * p[2] - q[1] * p[3] + q[2] * p[0] + q[3] * p[1], q[0] * p[3] + q[1] * p[2] - q[2] * p[1] + q[3] * p[0]};
}

inline Eigen::Vector4d quaternion_conjugate(const Eigen::Vector4d& q) { return {q[0], -q[1], -q[2], -q[3]}; }

/// q / |q|; q must not be zero.
inline Eigen::Vector4d quaternion_normalised(const Eigen::Vector4d& q) {
  const double s = 1.0 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] * s, q[1] * s, q[2] * s, q[3] * s};
}

/// The unit quaternion of a rotation vector (rad); full precision for every angle, zero included.
Eigen::Vector4d quaternion_exp(const Eigen::Vector3d& rotation_vector);

/// The shortest rotation vector (rad, norm <= pi) of a unit quaternion; well conditioned from zero to pi.
Eigen::Vector3d quaternion_log(const Eigen::Vector4d& q);

/// C(q) of a unit quaternion.
inline Eigen::Matrix3d dcm_from_quaternion(const Eigen::Vector4d& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double xx = 2.0 * x * x, yy = 2.0 * y * y, zz = 2.0 * z * z;
  const double xy = 2.0 * x * y, xz = 2.0 * x * z, yz = 2.0 * y * z;
  const double wx = 2.0 * w * x, wy = 2.0 * w * y, wz = 2.0 * w * z;
  Eigen::Matrix3d c;
  c(0, 0) = 1.0 - yy - zz, c(0, 1) = xy - wz, c(0, 2) = xz + wy;
  c(1, 0) = xy + wz, c(1, 1) = 1.0 - xx - zz, c(1, 2) = yz - wx;
  c(2, 0) = xz - wy, c(2, 1) = yz + wx, c(2, 2) = 1.0 - xx - yy;
  return c;
}

/// The unit quaternion, w >= 0, of a rotation matrix (Shepperd's choice of the largest component).
Eigen::Vector4d quaternion_from_dcm(const Eigen::Matrix3d& c);

/// (roll, pitch, yaw), rad, of C_nb = Rz(yaw) Ry(pitch) Rx(roll). Roll and yaw lie in [-pi, pi], pitch in
/// [-pi/2, pi/2]. Near |pitch| = pi/2 only yaw ∓ roll is determined: the split is arbitrary, the attitude is kept.
Eigen::Vector3d euler_from_quaternion(const Eigen::Vector4d& q_nb);
Eigen::Vector4d quaternion_from_euler(const Eigen::Vector3d& roll_pitch_yaw);

/// ∂(roll, pitch, yaw)/∂φ of C_nb turned by a small φ in navigation axes, exp(φ) ∘ C_nb: the inverse of
/// φ = Rz(yaw) Ry(pitch) x̂ d roll + Rz(yaw) ŷ d pitch + ẑ d yaw. False, and J untouched, within 1 mrad of the vertical,
/// where roll and yaw have no derivative that holds for an error of that size.
bool euler_jacobian(const Eigen::Vector4d& q_nb, Eigen::Ref<Eigen::Matrix3d, 0, Eigen::OuterStride<>> J);

/// J of exp(phi + d) = exp(J(phi) d) ∘ exp(phi) + O(d²), and its inverse (|phi| < 2 pi).
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi);
Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& phi);

/// Attitude ⊞ and ⊟ of the tilt error phi (rad, navigation components): q_true = exp(phi) ⊗ q_hat, that is
/// C_hat = (I − [phi×]) C_true to first order. attitude_minus(attitude_plus(q, phi), q) == phi for |phi| < pi.
Eigen::Vector4d attitude_plus(const Eigen::Vector4d& q_nb, const Eigen::Vector3d& phi);
Eigen::Vector3d attitude_minus(const Eigen::Vector4d& q_nb, const Eigen::Vector4d& from_q_nb);

}  // namespace binnacle::strapdown
