// SPDX-License-Identifier: Apache-2.0
// Zero angular rate: what the gyroscopes show of a body at rest is the earth's rate and their bias.
#include "zero_rate.hpp"

#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::land {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

FieldSpec body_rate(std::string name) {
  return field::rate(std::move(name), "rad/s").about("mean angular rate with respect to inertial space, body axes");
}

}  // namespace

ComponentSpec ZeroRate::spec() {
  ComponentSpec spec;
  spec.type = "zero_rate";
  spec.summary = "Zero angular rate: at each sample of its channel the body does not rotate relative to the earth.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 15.3.2";
  spec.parameters = {parameter::vector("sigma", "rad/s", 3)
                         .above(0)
                         .plausible(1e-8, 0.5)
                         .required()
                         .about("standard deviation of a sample's mean rate from noise and vibration, body axes"),
                     Spacing::parameter()};
  spec.ports = {
      reads("gyro_bias", "vector:3:rad/s").about("bias of the gyroscopes"),
      reads("attitude", "attitude").optional().about("attitude of the body; with the position, for the earth rate"),
      reads("position", "position").optional().about("position of the body; with the attitude, for the earth rate")};
  spec.fields = {body_rate("wx"), body_rate("wy"), body_rate("wz")};
  spec.example = R"json({"channel": "motion.standing", "blocks": {"gyro_bias": "gyro_bias", "attitude": "attitude",
    "position": "position"}, "sigma": "0.005 deg/s"})json";
  return spec;
}

ZeroRate::ZeroRate(const Binding& binding)
    : gyro_bias_(binding.port("gyro_bias")),
      attitude_(binding.port("attitude")),
      position_(binding.port("position")),
      omega_(binding.fields("wx", "wy", "wz")),
      spacing_(binding, declaration_),
      variance_(binding.parameters().vector("sigma").cwiseAbs2()),
      has_earth_(attitude_.is_bound() && position_.is_bound()) {
  if (attitude_.is_bound() != position_.is_bound())
    throw ComponentError("the earth's rate needs both 'attitude' and 'position'", "/blocks");
  declaration_.rows(3).reads(gyro_bias_).reads(attitude_).reads(position_).group(rows::these("rate", 3, "rad/s"));
}

Result ZeroRate::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const Vector3d measured = in.sample[omega_];
  if (!measured.allFinite()) return Result::invalid("an angular rate is not finite");
  if (const Result result = spacing_.pass(in); !result) return result;
  out.rows = 3;
  out.residual.as<3>() = measured - in.x[gyro_bias_].as<3>();
  if (const MatrixView H = out.H[gyro_bias_]) H.as<3, 3>().setIdentity();
  out.R.as<3, 3>().diagonal() = variance_;
  if (!has_earth_) return Result::ok();

  const Matrix3d C_bn = strapdown::dcm_from_quaternion(in.x[attitude_].as<4>()).transpose();
  const double lat = in.x[position_][0], height = in.x[position_][2];
  const Vector3d omega = strapdown::omega_ie_n(lat);
  out.residual.as<3>() -= C_bn * omega;
  if (const MatrixView H = out.H[attitude_]) H.as<3, 3>() = C_bn * strapdown::skew(omega);
  if (const MatrixView H = out.H[position_]) {
    const Vector3d by_north = Vector3d(omega[2], 0.0, -omega[0]) / (strapdown::radii(lat).meridian + height);
    H.as<3, 3>().col(0) = C_bn * by_north;
  }
  return Result::ok();
}

}  // namespace binnacle::land
