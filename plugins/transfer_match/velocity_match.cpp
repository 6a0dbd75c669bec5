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

enum Port { velocity_port, lever_arm_port, attitude_port, gyro_bias_port };
enum Field { vn, ve, vd, roll, pitch, yaw, lat };

FieldSpec speed(std::string name, bool is_optional, std::string text) {
  return {std::move(name), "m/s", FieldKind::level, is_optional, false, std::move(text)};
}
FieldSpec angle(std::string name, std::string text) {
  return {std::move(name), "rad", FieldKind::level, true, false, std::move(text)};
}
FieldSpec rate(std::string name) {
  return {std::move(name), "rad/s",
          FieldKind::rate, true,
          false,           "angular rate of the slave with respect to inertial space, for a lever arm"};
}

}  // namespace

ComponentSpec VelocityMatch::spec() {
  ComponentSpec spec;
  spec.type = "velocity_match";
  spec.summary = "Velocity match of transfer alignment: the master's velocity against the slave's.";
  spec.source =
      "paper 000, equation (2); lever arm: Groves, Principles of GNSS, Inertial, and Multisensor Integrated "
      "Navigation Systems, 2nd ed., section 15.1";
  spec.parameters = {
      parameter::vector("sigma", "m/s", 3)
          .above(0)
          .required()
          .about("standard deviation of the master's velocity, north, east, down, at each sample"),
      parameter::choice("axes", {"horizontal", "all"}).defaults("\"horizontal\"").about("north and east, or down too")};
  spec.ports = {
      reads("velocity", "velocity.ned", "of the slave (SINS)"),
      may_read("lever_arm", "vector:3:m", "from the master to the slave, in the master's body axes").formerly("arm"),
      may_read("attitude", "attitude", "of the slave; needed with a lever arm"),
      may_read("gyro_bias", "vector:3:rad/s", "of the slave, taken off its rate; for a lever arm")};
  spec.fields = {speed("vn", false, "of the master (MINS) over ground, north"),
                 speed("ve", false, "of the master over ground, east"),
                 speed("vd", true, "of the master over ground, down; needed for all axes"),
                 angle("roll", "of the master; needed with a lever arm"),
                 angle("pitch", "of the master; needed with a lever arm"),
                 angle("yaw", "of the master; needed with a lever arm"),
                 angle("lat", "of the master; with it the earth's rate is taken off the slave's, for a lever arm")};
  spec.driving_rates = {rate("wx"), rate("wy"), rate("wz")};
  spec.example = R"json({"channel": "mins", "blocks": {"velocity": "velocity"}, "sigma": "0.257 m/s"})json";
  return spec;
}

VelocityMatch::VelocityMatch(const Binding& binding)
    : variance_(binding.parameters().vector("sigma").cwiseAbs2()),
      rows_(binding.parameters().text("axes") == "all" ? 3 : 2),
      has_lever_arm_(binding.is_bound("lever_arm")),
      has_latitude_(binding.has_field(lat)) {
  if (rows_ == 3 && !binding.has_field(vd))
    throw ComponentError("'axes' is 'all', but the channel has no 'vd'", "/axes");
  if (has_lever_arm_ && !binding.is_bound("attitude"))
    throw ComponentError("a lever arm needs the slave's attitude: plug a block into port 'attitude'",
                         "/blocks/lever_arm");
  for (const Field field : {roll, pitch, yaw})
    if (has_lever_arm_ && !binding.has_field(field))
      throw ComponentError("a lever arm needs the master's roll, pitch and yaw in the channel", "/blocks/lever_arm");
  declaration_.max_rows = rows_;
  declaration_.read_ports = {velocity_port};
  if (has_lever_arm_) {
    declaration_.read_ports.push_back(lever_arm_port);
    declaration_.read_ports.push_back(attitude_port);
    if (binding.is_bound("gyro_bias")) declaration_.read_ports.push_back(gyro_bias_port);
  }
  declaration_.groups = {{"velocity", 0, rows_, "m/s", rows_ == 3 ? static_cast<int>(velocity_port) : -1}};
}

Vector3d VelocityMatch::earth_rate(const SampleView& sample) const {
  return has_latitude_ ? strapdown::omega_ie_n(sample.fields[lat]) : Vector3d::Zero();
}

Result VelocityMatch::linearize(const SampleView& sample, const SampleView* /*auxiliary*/, const double* const* x,
                                const legacy::Context& context, std::byte* /*memory*/,
                                legacy::Linearization& out) const {
  const double* z = sample.fields;
  for (int row = 0; row < rows_; ++row) {
    if (!std::isfinite(z[row])) return Result::invalid("a velocity of the master is not finite");
    out.residual[row] = z[row] - x[velocity_port][row];
    out.H[0](row, row) = 1.0;
    out.R(row, row) = variance_[row];
  }
  out.rows = rows_;
  if (!has_lever_arm_) return Result::ok();

  if (!context.driving_rates)
    return Result::unsupported("a lever arm needs the slave's rate, and no input sample has come yet");
  if (!vector_at<3>(z + roll).allFinite()) return Result::invalid("an angle of the master is not finite");
  const Matrix3d C_M = strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(vector_at<3>(z + roll)));
  const Matrix3d C_S = strapdown::dcm_from_quaternion(vector_at<4>(x[attitude_port]));
  Vector3d omega = vector_at<3>(context.driving_rates);
  if (x[gyro_bias_port]) omega -= vector_at<3>(x[gyro_bias_port]);
  const Vector3d omega_ib_n = C_S * omega, omega_eb_n = omega_ib_n - earth_rate(sample);
  const Vector3d lever_arm_n = C_M * vector_at<3>(x[lever_arm_port]);
  const Vector3d turning_n = omega_eb_n.cross(lever_arm_n);
  const Matrix3d minus_arm = skew(-lever_arm_n);
  const Matrix3d by_arm = skew(-omega_eb_n) * C_M;
  const Matrix3d by_attitude = minus_arm * skew(omega_ib_n);
  for (int row = 0; row < rows_; ++row) out.residual[row] += turning_n[row];
  out.H[1].as().topRows(rows_) = by_arm.topRows(rows_);
  out.H[2].as().topRows(rows_) = by_attitude.topRows(rows_);
  if (declaration_.read_ports.size() > 3) out.H[3].as().topRows(rows_) = (minus_arm * C_S).topRows(rows_);
  return Result::ok();
}

}  // namespace binnacle::transfer_match
