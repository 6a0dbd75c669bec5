// SPDX-License-Identifier: Apache-2.0
// A velocity in the axes of the vehicle, with what it depends on.
#include "vehicle_velocity.hpp"

#include "binnacle/parameters.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::land {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

enum Port { velocity, attitude, misalignment };

}  // namespace

std::vector<PortSpec> VehicleVelocity::ports() {
  return {reads("velocity", "velocity.ned", "of the point that does not slip: a lever_arm_velocity to the rear axle"),
          reads("attitude", "attitude",
                "of the vehicle as it is thought to be: a mounted_attitude unless the IMU's axes are its"),
          may_read("misalignment", "vector:*:rad",
                   "zeta of paper 001 (5), vehicle axes: x y z, or two components y z")};
}

VehicleVelocity::VehicleVelocity(const Binding& binding) : angles_(binding.block("misalignment").dof) {
  if (binding.is_bound("misalignment") && angles_ != 2 && angles_ != 3)
    throw ComponentError("a misalignment has three components, x y z, or two, y z", "/blocks/misalignment");
}

std::vector<int> VehicleVelocity::read_ports() const {
  if (angles_ > 0) return {velocity, attitude, misalignment};
  return {velocity, attitude};
}

VehicleVelocity::Value VehicleVelocity::at(const double* const* x) const {
  const Matrix3d C_nb = strapdown::dcm_from_quaternion(vector_at<4>(x[attitude]));
  const Vector3d v_n = vector_at<3>(x[velocity]);
  Value value;
  value.by_misalignment.setZero();
  if (angles_ == 0) {
    value.by_velocity = C_nb.transpose();
    value.v_v = value.by_velocity * v_n;
  } else {
    Vector3d zeta = Vector3d::Zero();
    for (int i = 0; i < angles_; ++i) zeta[3 - angles_ + i] = x[misalignment][i];
    value.by_velocity = strapdown::dcm_from_quaternion(strapdown::quaternion_exp(zeta)) * C_nb.transpose();
    value.v_v = value.by_velocity * v_n;
    value.by_misalignment = -strapdown::skew(value.v_v) * strapdown::left_jacobian(zeta);
  }
  value.by_attitude = value.by_velocity * strapdown::skew(v_n);
  return value;
}

}  // namespace binnacle::land
