// SPDX-License-Identifier: Apache-2.0
// Zero-velocity update.
#include "zupt.hpp"

namespace binnacle::land {

ComponentSpec Zupt::spec() {
  ComponentSpec spec;
  spec.type = "zupt";
  spec.summary = "Zero-velocity update: at each sample of its channel the vehicle stands still.";
  spec.source = "paper 001, equation (10)";
  spec.parameters = {parameter::vector("sigma", "m/s", 3)
                         .above(0)
                         .plausible(1e-4, 10)
                         .required()
                         .about("standard deviation of the velocity of the standing vehicle, north, east, down"),
                     Spacing::parameter()};
  spec.ports = {reads("velocity", "velocity.ned").about("velocity that is zero")};
  spec.example = R"json({"channel": "motion.standing", "blocks": {"velocity": "velocity"}, "sigma": "0.02 m/s"})json";
  return spec;
}

Zupt::Zupt(const Binding& binding)
    : velocity_(binding.port("velocity")),
      spacing_(binding, declaration_),
      variance_(binding.parameters().vector("sigma").cwiseAbs2()) {
  declaration_.rows(3).reads(velocity_).group(rows::of("velocity", velocity_));
}

Result Zupt::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  if (const Result result = spacing_.pass(in); !result) return result;
  out.rows = 3;
  out.residual.as<3>() = -in.x[velocity_].as<3>();
  if (const MatrixView H = out.H[velocity_]) H.as<3, 3>().setIdentity();
  out.R.as<3, 3>().diagonal() = variance_;
  return Result::ok();
}

}  // namespace binnacle::land
