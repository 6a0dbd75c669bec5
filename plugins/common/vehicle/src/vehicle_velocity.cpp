// SPDX-License-Identifier: Apache-2.0
// A velocity in the axes of the vehicle or of a sensor on it, with what it depends on.
#include "vehicle/vehicle_velocity.hpp"

#include <utility>

#include "binnacle/parameters.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::vehicle {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

}  // namespace

std::vector<PortSpec> VehicleVelocity::ports(std::string of_point, std::string of_axes) {
  return {reads("velocity", "velocity.ned").about(std::move(of_point)),
          reads("attitude", "attitude").about(std::move(of_axes)),
          reads("misalignment", "vector:*:rad")
              .optional()
              .about("zeta of paper 001 (5), vehicle axes: x y z, or two components y z")};
}

VehicleVelocity::VehicleVelocity(const Binding& binding, MeasurementDeclaration& declaration)
    : velocity_(binding.port("velocity")),
      attitude_(binding.port("attitude")),
      misalignment_(binding.port("misalignment")) {
  if (misalignment_.is_bound() && misalignment_.dof() != 2 && misalignment_.dof() != 3)
    throw ComponentError("a misalignment has three components, x y z, or two, y z", "/blocks/misalignment");
  declaration.reads(velocity_).reads(attitude_).reads(misalignment_);
}

VehicleVelocity::Value VehicleVelocity::at(const PortValues& x) const {
  const Matrix3d C_nb = strapdown::dcm_from_quaternion(x[attitude_].as<4>());
  const Vector3d v_n = x[velocity_].as<3>();
  Value value;
  value.by_misalignment.setZero();
  if (!misalignment_.is_bound()) {
    value.by_velocity = C_nb.transpose();
    value.v_v = value.by_velocity * v_n;
  } else {
    Vector3d zeta = Vector3d::Zero();
    zeta.tail(misalignment_.dof()) = x[misalignment_].as();
    value.by_velocity = strapdown::dcm_from_quaternion(strapdown::quaternion_exp(zeta)) * C_nb.transpose();
    value.v_v = value.by_velocity * v_n;
    value.by_misalignment = -strapdown::skew(value.v_v) * strapdown::left_jacobian(zeta);
  }
  value.by_attitude = value.by_velocity * strapdown::skew(v_n);
  return value;
}

}  // namespace binnacle::vehicle
