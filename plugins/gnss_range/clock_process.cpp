// SPDX-License-Identifier: Apache-2.0
// How a receiver's clock wanders: two states.
#include "clock_process.hpp"

namespace binnacle::gnss_range {

ComponentSpec ClockProcess::spec() {
  ComponentSpec spec;
  spec.type = "clock_drift";
  spec.summary =
      "A receiver's clock: the drift is a random walk, the bias is the integral of the drift and of white noise.";
  spec.source = "paper 003, equation (4); Brown and Hwang, Introduction to Random Signals, 3rd ed., section 11.2";
  spec.parameters = {parameter::number("S_f", "m^2/s")
                         .at_least(0)
                         .plausible(1e-10, 1e4)
                         .required()
                         .about("power spectral density of the white frequency noise, times c^2"),
                     parameter::number("S_g", "m^2/s^3")
                         .at_least(0)
                         .plausible(1e-16, 1e4)
                         .required()
                         .about("power spectral density of the random walk of the frequency, times c^2")};
  spec.ports = {advances("clock", "receiver_clock").about("bias and drift")};
  spec.example = R"json({"blocks": {"clock": "clock"}, "S_f": "0.009 m^2/s", "S_g": "0.0355 m^2/s^3"})json";
  spec.surroundings =
      R"json({"blocks": {"clock": {"type": "gnss_range/receiver_clock", "init": {"bias": 0, "drift": 0}, "sigma": ["1 m", "0.1 m/s"]}}})json";
  return spec;
}

ClockProcess::ClockProcess(const Binding& binding)
    : clock_(binding.port("clock")),
      phi_(declaration_.couples(clock_, clock_)),
      q_(declaration_.adds_noise(clock_, clock_)),
      S_f_(binding.parameters().number("S_f")),
      S_g_(binding.parameters().number("S_g")) {}

Result ClockProcess::propagate(const ProcessInput& in, ProcessOutput& out) const {
  const double dt = in.step.dt;
  const double bias = in.x[clock_][0], drift = in.x[clock_][1];
  out.x[clock_][0] = bias + dt * drift;
  out.x[clock_][1] = drift;
  if (const BlockView phi = out.phi[phi_]) phi.as<2, 2>() << 1, dt, 0, 1;
  if (const BlockView Q = out.Qd[q_]) {
    const double cross = S_g_ * dt * dt / 2;
    Q.as<2, 2>() << S_f_ * dt + S_g_ * dt * dt * dt / 3, cross, cross, S_g_ * dt;
  }
  return Result::ok();
}

}  // namespace binnacle::gnss_range
