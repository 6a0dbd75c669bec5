// SPDX-License-Identifier: Apache-2.0
// The direction of the horizontal velocity.
#include "course.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace binnacle::aiding {

ComponentSpec Course::spec() {
  ComponentSpec spec;
  spec.type = "course";
  spec.summary = "The direction of the horizontal velocity, if the speed is missing or not reliable.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 6.1.4";
  spec.parameters = {Deviations::parameter(1, "rad", 1e-5, 2),
                     parameter::number("velocity_sigma", "m/s")
                         .at_least(0)
                         .plausible(1e-4, 10)
                         .defaults("\"0.1 m/s\"")
                         .about("1-sigma of the velocity from which the course is computed: adds (velocity_sigma / "
                                "speed)^2 to the variance"),
                     parameter::number("min_speed", "m/s")
                         .above(0)
                         .defaults("\"1 m/s\"")
                         .about("least horizontal speed of the estimate; samples at lower speeds are unsupported")};
  spec.ports = {reads("velocity", "velocity.ned").about("velocity of the antenna: a lever_arm_velocity")};
  spec.fields = {field::level("course", "rad").about("course over ground, clockwise from north"),
                 Deviations::field("course", "rad")};
  spec.example =
      R"json({"channel": "log", "blocks": {"velocity": "velocity"}, "sigma": "0.5 deg", "min_speed": "2 m/s"})json";
  spec.surroundings = R"json({"blocks": {
    "velocity": {"type": "navigation/velocity", "init": {"vn": -12, "ve": -9, "vd": 0.3}, "sigma": 0.3}},
    "sample": {"course": -2.4, "course_sd": 0.02}})json";
  return spec;
}

Course::Course(const Binding& binding)
    : velocity_(binding.port("velocity")),
      course_(binding.field("course")),
      sigma_(binding, std::array{"course"}),
      velocity_sigma_(binding.parameters().number("velocity_sigma")),
      min_speed_(binding.parameters().number("min_speed")) {
  declaration_.rows(1).reads(velocity_).group(rows::these("course", 1, "rad"));
}

Result Course::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const double z = in.sample[course_];
  if (!std::isfinite(z)) return Result::invalid("the course is not finite");
  if (const Result result = sigma_.write_variances(in.sample, out.R); !result) return result;
  const double north = in.x[velocity_][0], east = in.x[velocity_][1], square = north * north + east * east;
  if (!(std::sqrt(square) >= min_speed_)) return Result::unsupported("slower than 'min_speed'");
  out.rows = 1;
  out.residual[0] = std::remainder(z - std::atan2(east, north), 2 * std::numbers::pi);
  out.R(0, 0) += velocity_sigma_ * velocity_sigma_ / square;
  if (const MatrixView H = out.H[velocity_]) H.as<1, 3>() = Eigen::RowVector3d(-east / square, north / square, 0);
  return Result::ok();
}

}  // namespace binnacle::aiding
