// SPDX-License-Identifier: Apache-2.0
// Rotations in three dimensions.
#include "strapdown/rotation.hpp"

#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "series.hpp"

namespace binnacle::strapdown {

Eigen::Vector4d quaternion_exp(const Eigen::Vector3d& rotation_vector) { return detail::exp(rotation_vector); }

Eigen::Vector3d quaternion_log(const Eigen::Vector4d& q) {
  const double sign = q[0] < 0.0 ? -1.0 : 1.0;
  const double w = sign * q[0];
  const Eigen::Vector3d v = sign * q.tail<3>();
  const double s = v.stableNorm();
  // 2 atan2(s, w)/s = (2/w)(1 − s²/(3w²) + …): below 1e-8 the first term is exact in double precision.
  const double angle_over_s = s < 1e-8 * w ? 2.0 / w : 2.0 * std::atan2(s, w) / s;
  return v * angle_over_s;
}

Eigen::Vector4d quaternion_from_dcm(const Eigen::Matrix3d& c) {
  // Shepperd (1978): of 4w², 4x², 4y², 4z² divide by the largest, so nothing is lost near half a turn.
  const double trace = c.trace();
  const Eigen::Vector4d four_squares = Eigen::Vector4d{1.0 + trace, 1.0 + 2.0 * c(0, 0) - trace,
                                                       1.0 + 2.0 * c(1, 1) - trace, 1.0 + 2.0 * c(2, 2) - trace};
  Eigen::Index largest = 0;
  four_squares.maxCoeff(&largest);
  Eigen::Vector4d q;
  switch (largest) {
    case 0: q << four_squares[0], c(2, 1) - c(1, 2), c(0, 2) - c(2, 0), c(1, 0) - c(0, 1); break;
    case 1: q << c(2, 1) - c(1, 2), four_squares[1], c(1, 0) + c(0, 1), c(0, 2) + c(2, 0); break;
    case 2: q << c(0, 2) - c(2, 0), c(1, 0) + c(0, 1), four_squares[2], c(2, 1) + c(1, 2); break;
    default: q << c(1, 0) - c(0, 1), c(0, 2) + c(2, 0), c(2, 1) + c(1, 2), four_squares[3]; break;
  }
  return quaternion_normalised(q[0] < 0.0 ? Eigen::Vector4d(-q) : q);
}

Eigen::Vector3d euler_from_quaternion(const Eigen::Vector4d& q_nb) {
  const Eigen::Matrix3d c = dcm_from_quaternion(q_nb);
  const double pitch = std::atan2(-c(2, 0), std::hypot(c(0, 0), c(1, 0)));
  const double yaw = std::atan2(c(1, 0), c(0, 0));
  // Roll after yaw has been taken off, Rz(yaw)ᵀ C = Ry(pitch) Rx(roll): consistent with the yaw chosen even where yaw
  // itself is ill conditioned.
  const double sy = std::sin(yaw), cy = std::cos(yaw);
  const double roll = std::atan2(sy * c(0, 2) - cy * c(1, 2), cy * c(1, 1) - sy * c(0, 1));
  return {roll, pitch, yaw};
}

bool euler_jacobian(const Eigen::Vector4d& q_nb, Eigen::Ref<Eigen::Matrix3d, 0, Eigen::OuterStride<>> J) {
  constexpr double nearest_to_vertical = 1e-3;  // cos(pitch)
  // C_nb = Rz(yaw) Ry(pitch) Rx(roll) has the first column (cp cy, cp sy, −sp).
  const auto [w, x, y, z] = std::array{q_nb[0], q_nb[1], q_nb[2], q_nb[3]};
  const double c00 = 1.0 - 2.0 * (y * y + z * z), c10 = 2.0 * (x * y + w * z), c20 = 2.0 * (x * z - w * y);
  const double cos_pitch = std::sqrt(c00 * c00 + c10 * c10);
  if (!(cos_pitch > nearest_to_vertical)) return false;
  const double cos_yaw = c00 / cos_pitch, sin_yaw = c10 / cos_pitch, tan_pitch = -c20 / cos_pitch;
  J << cos_yaw / cos_pitch, sin_yaw / cos_pitch, 0.0,  //
      -sin_yaw, cos_yaw, 0.0,                          //
      tan_pitch * cos_yaw, tan_pitch * sin_yaw, 1.0;
  return true;
}

Eigen::Vector4d quaternion_from_euler(const Eigen::Vector3d& roll_pitch_yaw) {
  const Eigen::Vector3d half = 0.5 * roll_pitch_yaw;
  const double cr = std::cos(half[0]), sr = std::sin(half[0]);
  const double cp = std::cos(half[1]), sp = std::sin(half[1]);
  const double cy = std::cos(half[2]), sy = std::sin(half[2]);
  return {cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
          cr * cp * sy - sr * sp * cy};
}

Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi) {
  const double squared = phi.squaredNorm();
  const Eigen::Matrix3d cross = skew(phi);
  return Eigen::Matrix3d::Identity() + detail::one_minus_cos(squared) * cross +
         detail::angle_minus_sin(squared) * (cross * cross);
}

Eigen::Matrix3d left_jacobian_inverse(const Eigen::Vector3d& phi) {
  const double squared = phi.squaredNorm();
  const Eigen::Matrix3d cross = skew(phi);
  // (1 − (θ/2) cot(θ/2)) / θ²
  double coefficient = 0.0;
  if (squared < 0.01) {
    coefficient = 1.0 / 12.0 + squared * (1.0 / 720.0 + squared * (1.0 / 30240.0 + squared * (1.0 / 1209600.0)));
  } else {
    const double half = 0.5 * std::sqrt(squared);
    coefficient = (1.0 - half * std::cos(half) / std::sin(half)) / squared;
  }
  return Eigen::Matrix3d::Identity() - 0.5 * cross + coefficient * (cross * cross);
}

Eigen::Vector4d attitude_plus(const Eigen::Vector4d& q_nb, const Eigen::Vector3d& phi) {
  return quaternion_normalised(quaternion_product(quaternion_exp(phi), q_nb));
}

Eigen::Vector3d attitude_minus(const Eigen::Vector4d& q_nb, const Eigen::Vector4d& from_q_nb) {
  return quaternion_log(quaternion_product(q_nb, quaternion_conjugate(from_q_nb)));
}

}  // namespace binnacle::strapdown
