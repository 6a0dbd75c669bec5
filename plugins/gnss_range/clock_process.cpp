// SPDX-License-Identifier: Apache-2.0
// How a receiver's clock wanders: two states.
#include "clock_process.hpp"

#include "binnacle/view.hpp"

namespace binnacle::gnss_range {

ComponentSpec ClockProcess::spec() {
  ComponentSpec spec;
  spec.type = "clock_drift";
  spec.summary = "A receiver's clock: its drift is a random walk, its bias the integral of it and of white noise.";
  spec.source = "paper 003, equation (4); Brown and Hwang, Introduction to Random Signals, 3rd ed., section 11.2";
  spec.parameters = {parameter::number("S_f", "m^2/s")
                         .at_least(0)
                         .required()
                         .about("density of the white noise of frequency, times c^2"),
                     parameter::number("S_g", "m^2/s^3")
                         .at_least(0)
                         .required()
                         .about("density of the random walk of frequency, times c^2")};
  spec.ports = {advances("clock", "receiver_clock", "bias and drift")};
  spec.example = R"json({"blocks": {"clock": "clock"}, "S_f": "0.009 m^2/s", "S_g": "0.0355 m^2/s^3"})json";
  spec.surroundings =
      R"json({"blocks": {"clock": {"type": "gnss_range/receiver_clock", "init": {"bias": 0, "drift": 0}, "sigma": ["1 m", "0.1 m/s"]}}})json";
  return spec;
}

ClockProcess::ClockProcess(const Binding& binding)
    : S_f_(binding.parameters().number("S_f")), S_g_(binding.parameters().number("S_g")) {
  declaration_.transition = {{0, 0, Structure::dense}};
  declaration_.noise = {{0, 0, Structure::dense}};
}

Result ClockProcess::propagate(const Step& step, const double* const* x, std::byte* /*memory*/,
                               const legacy::ProcessOutput& out) const {
  const double dt = step.dt;
  out.x_plus[0][0] = x[0][0] + dt * x[0][1];
  out.x_plus[0][1] = x[0][1];
  matrix_at<2, 2>(out.transition[0]) << 1, dt, 0, 1;
  const double cross = S_g_ * dt * dt / 2;
  matrix_at<2, 2>(out.noise[0]) << S_f_ * dt + S_g_ * dt * dt * dt / 3, cross, cross, S_g_ * dt;
  return Result::ok();
}

}  // namespace binnacle::gnss_range
