// SPDX-License-Identifier: Apache-2.0
// Zero angular rate: what the gyroscopes tell of a body at rest is the earth's rate and their bias.
#include "zero_rate.hpp"

#include "binnacle/view.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::land {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

enum Port { gyro_bias, attitude, position };

FieldSpec rate(std::string name) {
  return {std::move(name), "rad/s", FieldKind::rate,
          false,           false,   "mean angular rate against inertial space, body axes"};
}

}  // namespace

ComponentSpec ZeroRate::spec() {
  ComponentSpec spec;
  spec.type = "zero_rate";
  spec.summary = "Zero angular rate: at each sample of its channel the body does not turn against the earth.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 15.3.2";
  spec.parameters = {parameter::vector("sigma", "rad/s", 3)
                         .above(0)
                         .required()
                         .about("standard deviation of a sample's mean rate, body axes: noise and shaking"),
                     Spacing::parameter()};
  spec.ports = {reads("gyro_bias", "vector:3:rad/s", "of the gyroscopes"),
                may_read("attitude", "attitude", "of the body; with the position, for the earth's rate"),
                may_read("position", "position", "of the body; with the attitude, for the earth's rate")};
  spec.fields = {rate("wx"), rate("wy"), rate("wz")};
  spec.example = R"json({"channel": "motion.standing", "blocks": {"gyro_bias": "gyro_bias", "attitude": "attitude",
    "position": "position"}, "sigma": "0.005 deg/s"})json";
  return spec;
}

ZeroRate::ZeroRate(const Binding& binding)
    : spacing_(binding),
      variance_(binding.parameters().vector("sigma").cwiseAbs2()),
      has_earth_(binding.is_bound("attitude") && binding.is_bound("position")) {
  if (binding.is_bound("attitude") != binding.is_bound("position"))
    throw ComponentError("the earth's rate needs both 'attitude' and 'position'", "/blocks");
  declaration_.max_rows = 3;
  declaration_.read_ports = {gyro_bias};
  if (has_earth_) declaration_.read_ports = {gyro_bias, attitude, position};
  declaration_.groups = {{"rate", 0, 3, "rad/s", -1}};
  declaration_.memory_bytes = spacing_.memory_bytes();
}

Result ZeroRate::linearize(const SampleView& sample, const SampleView* /*auxiliary*/, const double* const* x,
                           const legacy::Context& /*context*/, std::byte* memory, legacy::Linearization& out) const {
  const Vector3d measured = vector_at<3>(sample.fields);
  if (!measured.allFinite()) return Result::invalid("an angular rate is not finite");
  if (const Result result = spacing_.pass(sample.t, memory); !result) return result;
  out.rows = 3;
  vector_at<3>(out.residual) = measured - vector_at<3>(x[gyro_bias]);
  out.H[0].as<3, 3>().setIdentity();
  out.R.as<3, 3>().diagonal() = variance_;
  if (!has_earth_) return Result::ok();

  const Matrix3d C_bn = strapdown::dcm_from_quaternion(vector_at<4>(x[attitude])).transpose();
  const double lat = x[position][0], height = x[position][2];
  const Vector3d omega = strapdown::omega_ie_n(lat);
  vector_at<3>(out.residual) -= C_bn * omega;
  out.H[1].as<3, 3>() = C_bn * strapdown::skew(omega);
  const Vector3d by_north = Vector3d(omega[2], 0.0, -omega[0]) / (strapdown::radii(lat).meridian + height);
  out.H[2].as<3, 3>().col(0) = C_bn * by_north;
  return Result::ok();
}

}  // namespace binnacle::land
