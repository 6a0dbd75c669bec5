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

FieldSpec rate(std::string name) {
  return field::rate(std::move(name), "rad/s").about("angular rate with respect to inertial space, body axes");
}

/// The block on an optional port, or nothing.
Vector3d read_or_zero(ConstVectorView x) { return x ? Vector3d(x.as<3>()) : Vector3d::Zero(); }

struct EarthRate {
  Vector3d omega_ie_n = Vector3d::Zero();  // rad/s
  Vector3d by_north = Vector3d::Zero();    // rad/s/m
};

EarthRate earth_rate(ConstVectorView lla) {
  if (!lla) return {};
  const Vector3d omega = strapdown::omega_ie_n(lla[0]);
  const double r_m = strapdown::radii(lla[0]).meridian + lla[2];
  return {omega, Vector3d{omega[2], 0.0, -omega[0]} / r_m};
}

}  // namespace

ComponentSpec LeverArmVelocity::spec() {
  ComponentSpec spec;
  spec.type = "lever_arm_velocity";
  spec.summary = "The velocity of another point of a rotating body, such as an antenna or an axle.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., "
      "section 2.5.5";
  spec.kind = "velocity.ned";
  spec.parameters = {lever_arm_parameter()};
  spec.ports = {
      reads("velocity", "velocity.ned").about("velocity of the IMU"),
      reads("attitude", "attitude").about("attitude of the body"),
      reads("position", "position").optional().about("position of the IMU; with it the earth rate is subtracted"),
      reads("gyro_bias", "vector:3:rad/s").optional().about("gyro bias, subtracted from the measured rate"),
      reads("gyro_scale", "vector:3:1").optional().about("scale factor error of the measured rate"),
      lever_arm_port()};
  spec.driving_rates = {rate("wx"), rate("wy"), rate("wz")};
  spec.example = R"json({"blocks": {"velocity": "velocity", "attitude": "attitude", "position": "position",
    "gyro_bias": "gyro_bias"}, "lever_arm": ["0.6 m", "-0.1 m", "-1.2 m"]})json";
  return spec;
}

LeverArmVelocity::LeverArmVelocity(const Binding& binding)
    : velocity_(binding.port("velocity")),
      attitude_(binding.port("attitude")),
      position_(binding.port("position")),
      gyro_bias_(binding.port("gyro_bias")),
      gyro_scale_(binding.port("gyro_scale")),
      lever_arm_port_(binding.port("lever_arm")),
      omega_(binding.driving_rates("wx", "wy", "wz")),
      lever_arm_(fixed_lever_arm(binding)) {
  declaration_.yields_like(binding.block("velocity"));
  for (const Port port : {velocity_, attitude_, position_, gyro_bias_, gyro_scale_, lever_arm_port_})
    declaration_.reads(port);
}

Result LeverArmVelocity::evaluate(const DerivedInput& in, DerivedOutput& out) const {
  if (!in.u.rates) return Result::unsupported("the angular rate is not known before the first input sample");
  const Matrix3d C_nb = strapdown::dcm_from_quaternion(in.x[attitude_].as<4>());
  const Vector3d per_scale = (1.0 + read_or_zero(in.x[gyro_scale_]).array()).inverse();
  const Vector3d omega_ib = (in.u.rates[omega_] - read_or_zero(in.x[gyro_bias_])).cwiseProduct(per_scale);
  const Vector3d lever_arm = lever_arm_ + read_or_zero(in.x[lever_arm_port_]);
  const EarthRate earth = earth_rate(in.x[position_]);
  const Vector3d lever_arm_n = C_nb * lever_arm;
  const Vector3d turning_n = C_nb * omega_ib.cross(lever_arm);
  out.value.as<3>() = in.x[velocity_].as<3>() + turning_n - earth.omega_ie_n.cross(lever_arm_n);
  if (const MatrixView J = out.J[velocity_]) J.as<3, 3>().setIdentity();
  if (const MatrixView J = out.J[attitude_])
    J.as<3, 3>() = skew(earth.omega_ie_n) * skew(lever_arm_n) - skew(turning_n);
  if (const MatrixView J = out.J[position_]) J.as<3, 3>().col(0) = -earth.by_north.cross(lever_arm_n);
  if (const MatrixView J = out.J[gyro_bias_]) J.as<3, 3>() = C_nb * skew(lever_arm) * per_scale.asDiagonal();
  if (const MatrixView J = out.J[gyro_scale_])
    J.as<3, 3>() = C_nb * skew(lever_arm) * per_scale.cwiseProduct(omega_ib).asDiagonal();
  if (const MatrixView J = out.J[lever_arm_port_]) J.as<3, 3>() = C_nb * skew(omega_ib) - skew(earth.omega_ie_n) * C_nb;
  return Result::ok();
}

}  // namespace binnacle::frames
