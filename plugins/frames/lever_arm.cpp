// SPDX-License-Identifier: Apache-2.0
// The position of another point of the body.
#include "lever_arm.hpp"

#include "binnacle/view.hpp"
#include "lever_arm_input.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::frames {

namespace {

enum Port { position_port, attitude_port, arm_block_port };

}  // namespace

ComponentSpec LeverArm::spec() {
  ComponentSpec spec;
  spec.type = "lever_arm";
  spec.summary = "The position of another point of the body: an antenna, an axle.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., "
      "section 2.5.5";
  spec.kind = "position";
  spec.parameters = {lever_arm_parameter()};
  spec.ports = {reads("position", "position", "of the IMU"), reads("attitude", "attitude", "of the body"),
                lever_arm_port()};
  spec.example = R"json({"blocks": {"position": "position", "attitude": "attitude"},
    "lever_arm": ["0.6 m", "-0.1 m", "-1.2 m"]})json";
  return spec;
}

LeverArm::LeverArm(const Binding& binding)
    : lever_arm_(fixed_lever_arm(binding)), has_arm_port_(binding.is_bound("lever_arm")) {
  const PortBinding& position = binding.block("position");
  declaration_.kind = position.kind;
  declaration_.stored_size = position.stored_size;
  declaration_.error = position.components;
  declaration_.read_ports = {position_port, attitude_port};
  if (has_arm_port_) declaration_.read_ports.push_back(arm_block_port);
}

Result LeverArm::evaluate(const double* const* x, const legacy::Context& /*context*/, double* value,
                          const MatrixView* J) const {
  const Eigen::Matrix3d C_nb = strapdown::dcm_from_quaternion(vector_at<4>(x[attitude_port]));
  Eigen::Vector3d lever_arm = lever_arm_;
  if (has_arm_port_) lever_arm += vector_at<3>(x[arm_block_port]);
  const Eigen::Vector3d lever_arm_n = C_nb * lever_arm;
  vector_at<3>(value) = strapdown::position_plus(vector_at<3>(x[position_port]), lever_arm_n);
  if (J) {
    J[0].as<3, 3>().setIdentity();
    J[1].as<3, 3>() = -strapdown::skew(lever_arm_n);
    if (has_arm_port_) J[2].as<3, 3>() = C_nb;
  }
  return Result::ok();
}

}  // namespace binnacle::frames
