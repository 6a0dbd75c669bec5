// SPDX-License-Identifier: Apache-2.0
// The velocity of another point of a turning body.
#include "lever_arm_velocity.hpp"

#include <Eigen/Geometry>

#include "binnacle/view.hpp"
#include "lever_arm_input.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::frames {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using strapdown::skew;

enum Port { velocity_port, attitude_port, position_port, gyro_bias_port, gyro_scale_port, arm_block_port };

FieldSpec rate(std::string name) {
  return {name, "rad/s", FieldKind::rate, false, false, "angular rate with respect to inertial space, body axes"};
}

/// The block on an optional port, or nothing.
Vector3d read_or_zero(const double* x) { return x ? Vector3d(vector_at<3>(x)) : Vector3d::Zero(); }

struct EarthRate {
  Vector3d omega_ie_n = Vector3d::Zero();  // rad/s
  Vector3d by_north = Vector3d::Zero();    // rad/s/m
};

EarthRate earth_rate(const double* lla) {
  if (!lla) return {};
  const Vector3d omega = strapdown::omega_ie_n(lla[0]);
  const double r_m = strapdown::radii(lla[0]).meridian + lla[2];
  return {omega, Vector3d{omega[2], 0.0, -omega[0]} / r_m};
}

}  // namespace

ComponentSpec LeverArmVelocity::spec() {
  ComponentSpec spec;
  spec.type = "lever_arm_velocity";
  spec.summary = "The velocity of another point of a turning body: an antenna, an axle.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., "
      "section 2.5.5";
  spec.kind = "velocity.ned";
  spec.parameters = {lever_arm_parameter()};
  spec.ports = {reads("velocity", "velocity.ned", "of the IMU"),
                reads("attitude", "attitude", "of the body"),
                may_read("position", "position", "of the IMU; with it the earth's rate is taken off"),
                may_read("gyro_bias", "vector:3:rad/s", "taken off the measured rate"),
                may_read("gyro_scale", "vector:3:1", "scale factor error of the measured rate"),
                lever_arm_port()};
  spec.driving_rates = {rate("wx"), rate("wy"), rate("wz")};
  spec.example = R"json({"blocks": {"velocity": "velocity", "attitude": "attitude", "position": "position",
    "gyro_bias": "gyro_bias"}, "lever_arm": ["0.6 m", "-0.1 m", "-1.2 m"]})json";
  return spec;
}

LeverArmVelocity::LeverArmVelocity(const Binding& binding) : lever_arm_(fixed_lever_arm(binding)) {
  const PortBinding& velocity = binding.block("velocity");
  declaration_.kind = velocity.kind;
  declaration_.stored_size = velocity.stored_size;
  declaration_.error = velocity.components;
  for (int port = 0; port < static_cast<int>(binding.ports().size()); ++port)
    if (binding.ports()[static_cast<std::size_t>(port)].bound) declaration_.read_ports.push_back(port);
}

Result LeverArmVelocity::evaluate(const double* const* x, const legacy::Context& context, double* value,
                                  const MatrixView* J) const {
  if (!context.driving_rates) return Result::unsupported("the angular rate is not known before the first input sample");
  const Matrix3d C_nb = strapdown::dcm_from_quaternion(vector_at<4>(x[attitude_port]));
  const Vector3d per_scale = (1.0 + read_or_zero(x[gyro_scale_port]).array()).inverse();
  const Vector3d omega_ib =
      (vector_at<3>(context.driving_rates) - read_or_zero(x[gyro_bias_port])).cwiseProduct(per_scale);
  const Vector3d lever_arm = lever_arm_ + read_or_zero(x[arm_block_port]);
  const EarthRate earth = earth_rate(x[position_port]);
  const Vector3d lever_arm_n = C_nb * lever_arm;
  const Vector3d turning_n = C_nb * omega_ib.cross(lever_arm);
  vector_at<3>(value) = vector_at<3>(x[velocity_port]) + turning_n - earth.omega_ie_n.cross(lever_arm_n);
  if (!J) return Result::ok();

  for (std::size_t i = 0; i < declaration_.read_ports.size(); ++i) {
    auto block = J[i].as<3, 3>();
    switch (declaration_.read_ports[i]) {
      case velocity_port: block.setIdentity(); break;
      case attitude_port: block = skew(earth.omega_ie_n) * skew(lever_arm_n) - skew(turning_n); break;
      case position_port: block.col(0) = -earth.by_north.cross(lever_arm_n); break;
      case gyro_bias_port: block = C_nb * skew(lever_arm) * per_scale.asDiagonal(); break;
      case gyro_scale_port: block = C_nb * skew(lever_arm) * per_scale.cwiseProduct(omega_ib).asDiagonal(); break;
      default: block = C_nb * skew(omega_ib) - skew(earth.omega_ie_n) * C_nb; break;
    }
  }
  return Result::ok();
}

}  // namespace binnacle::frames
