// SPDX-License-Identifier: Apache-2.0
// A wheel sensor: speed along the vehicle's x axis.
#include "odometer.hpp"

#include <cmath>

namespace binnacle::land {

ComponentSpec Odometer::spec() {
  ComponentSpec spec;
  spec.type = "odometer";
  spec.summary = "Speed over ground along the vehicle's x axis, from a wheel sensor.";
  spec.source =
      "paper 001, equation (6), first row; scale factor: Groves, Principles of GNSS, Inertial, and Multisensor "
      "Integrated Navigation Systems, 2nd ed., section 16.2.3";
  spec.parameters = {
      parameter::number("sigma", "m/s").above(0).plausible(1e-4, 10).required().about("standard deviation of a sample"),
      parameter::number("relative", "1")
          .at_least(0)
          .defaults("0")
          .about("relative noise from wheel slip: adds (relative * speed)^2 to the variance"),
      parameter::number("min_speed", "m/s")
          .at_least(0)
          .defaults("0")
          .about("least speed; samples below it are unsupported, because many sensors do not report very low speeds")};
  spec.ports = vehicle_ports();
  spec.ports.push_back(reads("scale", "vector:1:1")
                           .optional()
                           .about("scale factor error s: the sensor reports (1 + s) times the speed"));
  spec.fields = {field::level("speed", "m/s").about("speed along the vehicle's x axis, negative in reverse")};
  spec.example = R"json({"channel": "wheel", "blocks": {"velocity": "velocity", "attitude": "attitude",
    "misalignment": "misalignment", "scale": "scale"}, "sigma": "0.05 m/s", "gate": 0.999})json";
  spec.surroundings = R"json({"blocks": {
      "velocity": {"type": "navigation/velocity", "init": {"vn": 12, "ve": -9, "vd": 0.3}, "sigma": 0.3},
      "attitude": {"type": "navigation/attitude", "init": {"roll": 0.02, "pitch": -0.03, "yaw": -0.6}, "sigma": 0.02},
      "misalignment": {"type": "core/vector", "size": 2, "unit": "rad", "init": {"x0": -0.01, "x1": 0.02}, "sigma": 0.03},
      "scale": {"type": "core/vector", "size": 1, "unit": "1", "init": {"x": 0.01}, "sigma": 0.02}}})json";
  return spec;
}

Odometer::Odometer(const Binding& binding)
    : velocity_(binding, declaration_),
      scale_(binding.port("scale")),
      speed_(binding.field("speed")),
      sigma_(binding.parameters().number("sigma")),
      relative_(binding.parameters().number("relative")),
      min_speed_(binding.parameters().number("min_speed")) {
  declaration_.rows(1).reads(scale_).group(rows::these("speed", 1, "m/s"));
}

Result Odometer::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const double speed = in.sample[speed_];
  if (!std::isfinite(speed)) return Result::invalid("the speed is not finite");
  if (std::abs(speed) < min_speed_) return Result::unsupported("slower than 'min_speed'");
  const auto value = velocity_.at(in.x);
  const double forward = value.v_v[0];
  const double factor = scale_.is_bound() ? 1.0 + in.x[scale_][0] : 1.0;
  out.rows = 1;
  out.residual[0] = speed - factor * forward;
  out.R(0, 0) = sigma_ * sigma_ + relative_ * speed * relative_ * speed;
  velocity_.write_jacobians(value, Eigen::RowVector3d(factor, 0, 0), out.H);
  if (const MatrixView H = out.H[scale_]) H(0, 0) = forward;
  return Result::ok();
}

}  // namespace binnacle::land
