// SPDX-License-Identifier: Apache-2.0
// The heading of a line on the body: two antennas, a compass.
#include "heading.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "strapdown/rotation.hpp"

namespace binnacle::aiding {

ComponentSpec Heading::spec() {
  ComponentSpec spec;
  spec.type = "heading";
  spec.summary = "The heading of a line on the body, from two antennas, a compass or a gyrocompass.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., sections 6.1.1 "
      "and "
      "10.2.5";
  spec.parameters = {
      Deviations::parameter(1, "rad", 1e-5, 1),
      parameter::vector("baseline", "1", 3)
          .defaults("[1, 0, 0]")
          .about("direction of the line in body axes, of any length: from the rear antenna to the front antenna; [0, "
                 "1, 0]: from left to right"),
      parameter::number("declination", "rad")
          .at_least(-std::numbers::pi)
          .at_most(std::numbers::pi)
          .defaults("0")
          .about("declination for a magnetic heading: true heading minus magnetic heading, east positive"),
      parameter::number("max_slope", "rad")
          .above(0)
          .below(std::numbers::pi / 2)
          .defaults("\"80 deg\"")
          .about("largest angle between the line and the horizon; samples with a steeper line are unsupported")};
  spec.ports = {reads("attitude", "attitude").about("attitude of the body, or a mounted_attitude of the unit"),
                reads("bias", "vector:1:rad")
                    .optional()
                    .about("bias of the measured heading, positive to the right: mounting of the baseline, or "
                           "deviation of a compass")};
  spec.fields = {field::level("heading", "rad").about("heading of the line, clockwise from north"),
                 Deviations::field("heading", "rad")};
  spec.example = R"json({"channel": "antennas", "blocks": {"attitude": "attitude", "bias": "heading_bias"},
    "baseline": [1, 0, 0], "sigma": "0.3 deg", "gate": 0.999})json";
  spec.surroundings = R"json({"blocks": {
    "attitude": {"type": "navigation/attitude", "init": {"roll": 0.1, "pitch": -0.2, "yaw": 3.0}, "sigma": 0.02},
    "heading_bias": {"type": "vector", "size": 1, "unit": "rad", "init": 0.01, "sigma": 0.02}},
    "sample": {"heading": -3.1, "heading_sd": 0.01}})json";
  return spec;
}

Heading::Heading(const Binding& binding)
    : attitude_(binding.port("attitude")),
      bias_(binding.port("bias")),
      heading_(binding.field("heading")),
      sigma_(binding, std::array{"heading"}),
      declination_(binding.parameters().number("declination")),
      least_(std::cos(binding.parameters().number("max_slope"))),
      baseline_b_(binding.parameters().vector("baseline")) {
  if (!(baseline_b_.norm() > 0)) throw ComponentError("a baseline of no length has no direction", "/baseline");
  baseline_b_.normalize();
  declaration_.rows(1).reads(attitude_).reads(bias_).group(rows::these("heading", 1, "rad"));
}

Result Heading::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const double z = in.sample[heading_];
  if (!std::isfinite(z)) return Result::invalid("the heading is not finite");
  if (const Result result = sigma_.write_variances(in.sample, out.R); !result) return result;
  const Eigen::Vector3d u = strapdown::dcm_from_quaternion(in.x[attitude_].as<4>()) * baseline_b_;
  const double square = u[0] * u[0] + u[1] * u[1];
  if (!(std::sqrt(square) >= least_)) return Result::unsupported("the baseline is steeper than 'max_slope'");
  const double bias = bias_.is_bound() ? in.x[bias_][0] : 0;
  out.rows = 1;
  out.residual[0] = std::remainder(z - (std::atan2(u[1], u[0]) + bias - declination_), 2 * std::numbers::pi);
  if (const MatrixView H = out.H[attitude_])
    H.as<1, 3>() = Eigen::RowVector3d(-u[0] * u[2] / square, -u[1] * u[2] / square, 1);
  if (const MatrixView H = out.H[bias_]) H(0, 0) = 1;
  return Result::ok();
}

}  // namespace binnacle::aiding
