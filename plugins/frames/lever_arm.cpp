// SPDX-License-Identifier: Apache-2.0
// The position of another point of the body.
#include "lever_arm.hpp"

#include "binnacle/view.hpp"
#include "lever_arm_input.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::frames {

ComponentSpec LeverArm::spec() {
  ComponentSpec spec;
  spec.type = "lever_arm";
  spec.summary = "The position of another point of the body, such as an antenna or an axle.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., "
      "section 2.5.5";
  spec.kind = "position";
  spec.parameters = {lever_arm_parameter()};
  spec.ports = {reads("position", "position").about("position of the IMU"),
                reads("attitude", "attitude").about("attitude of the body"), lever_arm_port()};
  spec.example = R"json({"blocks": {"position": "position", "attitude": "attitude"},
    "lever_arm": ["0.6 m", "-0.1 m", "-1.2 m"]})json";
  return spec;
}

LeverArm::LeverArm(const Binding& binding)
    : position_(binding.port("position")),
      attitude_(binding.port("attitude")),
      lever_arm_port_(binding.port("lever_arm")),
      lever_arm_(fixed_lever_arm(binding)) {
  declaration_.yields_like(binding.block("position")).reads(position_).reads(attitude_).reads(lever_arm_port_);
}

Result LeverArm::evaluate(const DerivedInput& in, DerivedOutput& out) const {
  const Eigen::Matrix3d C_nb = strapdown::dcm_from_quaternion(in.x[attitude_].as<4>());
  Eigen::Vector3d lever_arm = lever_arm_;
  if (lever_arm_port_.is_bound()) lever_arm += in.x[lever_arm_port_].as<3>();
  const Eigen::Vector3d lever_arm_n = C_nb * lever_arm;
  out.value.as<3>() = strapdown::position_plus(in.x[position_].as<3>(), lever_arm_n);
  if (const MatrixView J = out.J[position_]) J.as<3, 3>().setIdentity();
  if (const MatrixView J = out.J[attitude_]) J.as<3, 3>() = -strapdown::skew(lever_arm_n);
  if (const MatrixView J = out.J[lever_arm_port_]) J.as<3, 3>() = C_nb;
  return Result::ok();
}

}  // namespace binnacle::frames
