// SPDX-License-Identifier: Apache-2.0
// Zero-velocity update.
#include "zupt.hpp"

#include "binnacle/view.hpp"

namespace binnacle::land {

ComponentSpec Zupt::spec() {
  ComponentSpec spec;
  spec.type = "zupt";
  spec.summary = "Zero-velocity update: at each sample of its channel the vehicle stands.";
  spec.source = "paper 001, equation (10)";
  spec.parameters = {parameter::vector("sigma", "m/s", 3)
                         .above(0)
                         .required()
                         .about("standard deviation of the velocity of standing, north, east, down"),
                     Spacing::parameter()};
  spec.ports = {reads("velocity", "velocity.ned", "that is zero")};
  spec.example = R"json({"channel": "motion.standing", "blocks": {"velocity": "velocity"}, "sigma": "0.02 m/s"})json";
  return spec;
}

Zupt::Zupt(const Binding& binding) : spacing_(binding), variance_(binding.parameters().vector("sigma").cwiseAbs2()) {
  declaration_.max_rows = 3;
  declaration_.read_ports = {0};
  declaration_.groups = {{"velocity", 0, 3, "m/s", 0}};
  declaration_.memory_bytes = spacing_.memory_bytes();
}

Result Zupt::linearize(const SampleView& sample, const SampleView* /*auxiliary*/, const double* const* x,
                       const legacy::Context& /*context*/, std::byte* memory, legacy::Linearization& out) const {
  if (const Result result = spacing_.pass(sample.t, memory); !result) return result;
  out.rows = 3;
  vector_at<3>(out.residual) = -vector_at<3>(x[0]);
  out.H[0].as<3, 3>().setIdentity();
  out.R.as<3, 3>().diagonal() = variance_;
  return Result::ok();
}

}  // namespace binnacle::land
