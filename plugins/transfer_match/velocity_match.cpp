// SPDX-License-Identifier: Apache-2.0
// A slave's velocity held against its master's.
#include "velocity_match.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::transfer_match {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using strapdown::skew;

FieldSpec speed(std::string name, std::string text) {
  return field::level(std::move(name), "m/s").about(std::move(text));
}
FieldSpec optional_angle(std::string name, std::string text) {
  return field::level(std::move(name), "rad").optional().about(std::move(text));
}
FieldSpec rate(std::string name) {
  return field::rate(std::move(name), "rad/s")
      .optional()
      .about("angular rate of the slave with respect to inertial space, for a lever arm");
}

}  // namespace

ComponentSpec VelocityMatch::spec() {
  ComponentSpec spec;
  spec.type = "velocity_match";
  spec.summary = "Velocity matching of transfer alignment: the velocities of the master and the slave.";
  spec.source =
      "paper 000, equation (2); lever arm: Groves, Principles of GNSS, Inertial, and Multisensor Integrated "
      "Navigation Systems, 2nd ed., section 15.1";
  spec.parameters = {parameter::vector("sigma", "m/s", 3)
                         .above(0)
                         .plausible(1e-4, 100)
                         .required()
                         .about("standard deviation of the master's velocity, north, east, down, at each sample"),
                     parameter::choice("axes", {"horizontal", "all"})
                         .defaults("\"horizontal\"")
                         .about("axes of the match: north and east, or also down")};
  spec.ports = {reads("velocity", "velocity.ned", "velocity of the slave (SINS)"),
                reads("lever_arm", "vector:3:m")
                    .optional()
                    .about("lever arm from the master to the slave, in the master's body axes")
                    .formerly("arm"),
                reads("attitude", "attitude").optional().about("attitude of the slave; required with a lever arm"),
                reads("gyro_bias", "vector:3:rad/s")
                    .optional()
                    .about("gyro bias of the slave, subtracted from its rate; for a lever arm")};
  spec.fields = {
      speed("vn", "velocity of the master (MINS) over ground, north"),
      speed("ve", "velocity of the master over ground, east"),
      speed("vd", "velocity of the master over ground, down; required for all axes").optional(),
      optional_angle("roll", "attitude of the master; required with a lever arm"),
      optional_angle("pitch", "attitude of the master; required with a lever arm"),
      optional_angle("yaw", "attitude of the master; required with a lever arm"),
      optional_angle(
          "lat",
          "position of the master; with it the earth rate is subtracted from the slave's rate, for a lever arm")};
  spec.driving_rates = {rate("wx"), rate("wy"), rate("wz")};
  spec.example = R"json({"channel": "mins", "blocks": {"velocity": "velocity"}, "sigma": "0.257 m/s"})json";
  return spec;
}

VelocityMatch::VelocityMatch(const Binding& binding)
    : velocity_(binding.port("velocity")),
      lever_arm_(binding.port("lever_arm")),
      attitude_(binding.port("attitude")),
      gyro_bias_(binding.port("gyro_bias")),
      v_(binding.fields("vn", "ve", "vd")),
      angles_(binding.fields("roll", "pitch", "yaw")),
      lat_(binding.field("lat")),
      omega_(binding.driving_rates("wx", "wy", "wz")),
      variance_(binding.parameters().vector("sigma").cwiseAbs2()),
      rows_(binding.parameters().text("axes") == "all" ? 3 : 2) {
  if (rows_ == 3 && !v_[2].is_bound()) throw ComponentError("'axes' is 'all', but the channel has no 'vd'", "/axes");
  if (lever_arm_.is_bound() && !attitude_.is_bound())
    throw ComponentError("a lever arm needs the slave's attitude: plug a block into port 'attitude'",
                         "/blocks/lever_arm");
  if (lever_arm_.is_bound() && !angles_.is_bound())
    throw ComponentError("a lever arm needs the master's roll, pitch and yaw in the channel", "/blocks/lever_arm");
  declaration_.rows(rows_).reads(velocity_);
  if (lever_arm_.is_bound()) declaration_.reads(lever_arm_).reads(attitude_).reads(gyro_bias_);
  declaration_.group(rows_ == 3 ? rows::of("velocity", velocity_) : rows::these("velocity", rows_, "m/s"));
}

Vector3d VelocityMatch::earth_rate(const SampleView& sample) const {
  return lat_.is_bound() ? strapdown::omega_ie_n(sample[lat_]) : Vector3d::Zero();
}

Result VelocityMatch::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const MatrixView H = out.H[velocity_];
  for (int row = 0; row < rows_; ++row) {
    const double z = in.sample[v_[row]];
    if (!std::isfinite(z)) return Result::invalid("a velocity of the master is not finite");
    out.residual[row] = z - in.x[velocity_][row];
    if (H) H(row, row) = 1.0;
    out.R(row, row) = variance_[row];
  }
  out.rows = rows_;
  return lever_arm_.is_bound() ? add_lever_arm(in, out) : Result::ok();
}

Result VelocityMatch::add_lever_arm(const MeasurementInput& in, MeasurementOutput& out) const {
  if (!in.u.rates) return Result::unsupported("a lever arm needs the slave's rate, and no input sample has come yet");
  const Vector3d angles = in.sample[angles_];
  if (!angles.allFinite()) return Result::invalid("an angle of the master is not finite");
  const Matrix3d C_M = strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(angles));
  const Matrix3d C_S = strapdown::dcm_from_quaternion(in.x[attitude_].as<4>());
  Vector3d omega = in.u.rates[omega_];
  if (gyro_bias_.is_bound()) omega -= in.x[gyro_bias_].as<3>();
  const Vector3d omega_ib_n = C_S * omega, omega_eb_n = omega_ib_n - earth_rate(in.sample);
  const Vector3d lever_arm_n = C_M * in.x[lever_arm_].as<3>();
  const Vector3d turning_n = omega_eb_n.cross(lever_arm_n);
  for (int row = 0; row < rows_; ++row) out.residual[row] += turning_n[row];
  const Matrix3d minus_arm = skew(-lever_arm_n);
  if (const MatrixView H = out.H[lever_arm_]) {
    const Matrix3d by_arm = skew(-omega_eb_n) * C_M;
    H.as() = by_arm.topRows(rows_);
  }
  if (const MatrixView H = out.H[attitude_]) {
    const Matrix3d by_attitude = minus_arm * skew(omega_ib_n);
    H.as() = by_attitude.topRows(rows_);
  }
  if (const MatrixView H = out.H[gyro_bias_]) H.as() = (minus_arm * C_S).topRows(rows_);
  return Result::ok();
}

}  // namespace binnacle::transfer_match
