// SPDX-License-Identifier: Apache-2.0
// A velocity over ground in body axes: a Doppler log, wheels.
#include "body_velocity.hpp"

#include <cmath>

namespace binnacle::aiding {

namespace {

using Eigen::Vector3d;
constexpr std::array<const char*, 3> names = {"vx", "vy", "vz"};

/// Null for those that the channel lacks.
std::array<const char*, 3> measured(const Binding& binding) {
  std::array<const char*, 3> there = names;
  for (const char*& name : there)
    if (!binding.field(name).is_bound()) name = nullptr;
  return there;
}

}  // namespace

ComponentSpec BodyVelocity::spec() {
  ComponentSpec spec;
  spec.type = "body_velocity";
  spec.summary =
      "A velocity over ground in body axes, from a Doppler log, wheels or a camera; scale factor and mounting can be "
      "estimated.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., sections 6.5 and "
      "16.2.5; mounting: paper 001, equation (5)";
  spec.parameters = {Deviations::parameter(3, "m/s", 1e-5, 10),
                     parameter::number("relative", "1")
                         .at_least(0)
                         .below(1)
                         .defaults("0")
                         .about("relative noise: adds (relative * measured speed)^2 to each variance")};
  spec.ports = vehicle::VehicleVelocity::ports(
      "velocity of the sensor: a lever_arm_velocity, unless the sensor is at the IMU",
      "nominal attitude of the sensor: a mounted_attitude, unless its axes are those of the IMU");
  spec.ports.push_back(
      reads("scale", "vector:*:1")
          .optional()
          .about("scale factor error s: the sensor reports (1 + s) times the velocity; one component, or x y z"));
  spec.fields = {field::level("vx", "m/s").optional().about("velocity over ground along the sensor's x, forward"),
                 field::level("vy", "m/s").optional().about("velocity over ground along y, right"),
                 field::level("vz", "m/s").optional().about("velocity over ground along z, down")};
  for (const char* name : names) spec.fields.push_back(Deviations::field(name, "m/s"));
  spec.example = R"json({"channel": "dvl", "blocks": {"velocity": "velocity", "attitude": "attitude",
    "misalignment": "misalignment", "scale": "scale"}, "sigma": "1 cm/s", "relative": 0.005, "gate": 0.999})json";
  spec.surroundings = R"json({"blocks": {
      "velocity": {"type": "navigation/velocity", "init": {"vn": 1.2, "ve": -0.9, "vd": 0.3}, "sigma": 0.1},
      "attitude": {"type": "navigation/attitude", "init": {"roll": 0.02, "pitch": -0.03, "yaw": -0.6}, "sigma": 0.02},
      "misalignment": {"type": "core/vector", "size": 3, "unit": "rad", "init": [0.01, -0.02, 0.03], "sigma": 0.03},
      "scale": {"type": "core/vector", "size": 1, "unit": "1", "init": {"x": 0.01}, "sigma": 0.02}},
    "sample": {"vx": 1.5, "vy": -0.1, "vz": 0.25, "vx_sd": 0.01, "vy_sd": 0.01, "vz_sd": 0.01}})json";
  return spec;
}

BodyVelocity::BodyVelocity(const Binding& binding)
    : velocity_(binding, declaration_),
      scale_(binding.port("scale")),
      z_(binding.fields("vx", "vy", "vz")),
      sigma_(binding, measured(binding)),
      relative_(binding.parameters().number("relative")) {
  for (int i = 0; i < 3; ++i)
    if (z_[i].is_bound()) axis_[static_cast<std::size_t>(rows_++)] = i;
  if (rows_ == 0) throw ComponentError("the channel carries none of 'vx', 'vy', 'vz'", "/fields");
  if (scale_.is_bound() && scale_.dof() != 1 && scale_.dof() != 3)
    throw ComponentError("a scale factor has one component, or three, x y z", "/blocks/scale");
  declaration_.rows(rows_).reads(scale_).group(rows::these("velocity", rows_, "m/s"));
}

Result BodyVelocity::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  if (const Result result = sigma_.write_variances(in.sample, out.R); !result) return result;
  Vector3d factor = Vector3d::Ones();
  if (scale_.dof() == 1) factor.array() += in.x[scale_][0];
  if (scale_.dof() == 3) factor += in.x[scale_].as<3>();
  const auto value = velocity_.at(in.x);
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, 3, 3> direction(rows_, 3);
  direction.setZero();
  double square = 0;
  for (int row = 0; row < rows_; ++row) {
    const int axis = axis_[static_cast<std::size_t>(row)];
    const double z = in.sample[z_[axis]];
    if (!std::isfinite(z)) return Result::invalid("a velocity is not finite");
    square += z * z;
    out.residual[row] = z - factor[axis] * value.v_v[axis];
    direction(row, axis) = factor[axis];
  }
  if (!std::isfinite(square)) return Result::invalid("the velocity is implausible");
  for (int row = 0; row < rows_; ++row) out.R(row, row) += relative_ * relative_ * square;
  out.rows = rows_;
  velocity_.write_jacobians(value, direction, out.H);
  if (const MatrixView H = out.H[scale_])
    for (int row = 0; row < rows_; ++row) {
      const int axis = axis_[static_cast<std::size_t>(row)];
      H(row, scale_.dof() == 1 ? 0 : axis) = value.v_v[axis];
    }
  return Result::ok();
}

}  // namespace binnacle::aiding
