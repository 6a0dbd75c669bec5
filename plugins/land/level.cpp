// SPDX-License-Identifier: Apache-2.0
// A vehicle on roads is level across, in the mean.
#include "level.hpp"

#include <cmath>

#include "strapdown/rotation.hpp"

namespace binnacle::land {

ComponentSpec Level::spec() {
  ComponentSpec spec;
  spec.type = "level";
  spec.summary = "Level: at each sample of its channel the roll of a road vehicle has zero mean.";
  spec.source = "cross slopes and springs even out; roll of C_nb = Rz(yaw) Ry(pitch) Rx(roll)";
  spec.parameters = {parameter::number("sigma", "rad")
                         .above(0)
                         .plausible(0.005, 1)
                         .required()
                         .about("standard deviation of the roll; the roll is correlated in time, so use several times "
                                "the cross slope of roads"),
                     Spacing::parameter()};
  spec.ports = {reads("attitude", "attitude").about("attitude of the vehicle, from the mounting angles")};
  spec.example =
      R"json({"channel": "motion.moving", "blocks": {"attitude": "attitude"}, "sigma": "8 deg", "spacing": "2 s"})json";
  return spec;
}

Level::Level(const Binding& binding)
    : attitude_(binding.port("attitude")),
      spacing_(binding, declaration_),
      variance_(std::pow(binding.parameters().number("sigma"), 2)) {
  declaration_.rows(1).reads(attitude_).group(rows::these("roll", 1, "rad"));
}

Result Level::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  const auto C = strapdown::dcm_from_quaternion(in.x[attitude_].as<4>());
  const double cos_pitch_squared = C(0, 0) * C(0, 0) + C(1, 0) * C(1, 0);
  constexpr double upright = 1e-6;
  if (cos_pitch_squared < upright) return Result::unsupported("the vehicle stands upright: it has no roll");
  if (const Result result = spacing_.pass(in); !result) return result;
  out.rows = 1;
  out.residual[0] = -std::atan2(C(2, 1), C(2, 2));
  if (const MatrixView H = out.H[attitude_]) {
    H(0, 0) = C(0, 0) / cos_pitch_squared;
    H(0, 1) = C(1, 0) / cos_pitch_squared;
    H(0, 2) = 0;
  }
  out.R(0, 0) = variance_;
  return Result::ok();
}

}  // namespace binnacle::land
