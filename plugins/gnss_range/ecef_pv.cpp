// SPDX-License-Identifier: Apache-2.0
// A receiver that moves with nearly constant velocity: the GPS-only filter.
#include "ecef_pv.hpp"

#include <algorithm>

namespace binnacle::gnss_range {

ComponentSpec EcefPv::spec() {
  ComponentSpec spec;
  spec.type = "ecef_pv";
  spec.summary =
      "Position and velocity in ECEF axes, driven by a white acceleration: a receiver without inertial sensors.";
  spec.source = "paper 003, section 4.2";
  spec.parameters = {
      parameter::number("S_a", "m^2/s^3")
          .at_least(0)
          .required()
          .about("density of the acceleration, in each direction: how much the vehicle manoeuvres"),
      parameter::number("S_v", "m^2/s")
          .at_least(0)
          .defaults("0")
          .about("density of white noise added to the velocity: position that wanders by itself; large: every epoch "
                 "stands alone")};
  spec.ports = {advances("position", "position.ecef", "of the antenna"),
                advances("velocity", "velocity.ecef", "of the antenna")};
  spec.example = R"json({"blocks": {"position": "r", "velocity": "v"}, "S_a": "0.12 m^2/s^3"})json";
  spec.surroundings = R"json({"blocks": {
    "r": {"type": "gnss_range/ecef_position", "init": {"x": -3976219, "y": 3382371, "z": 3652511}, "sigma": "10 m"},
    "v": {"type": "gnss_range/ecef_velocity", "init": {"vx": 0, "vy": 0, "vz": 0}, "sigma": "1 m/s"}}})json";
  return spec;
}

EcefPv::EcefPv(const Binding& binding)
    : S_a_(binding.parameters().number("S_a")), S_v_(binding.parameters().number("S_v")) {
  declaration_.transition = {{0, 1, Structure::diagonal}};
  declaration_.noise = {{0, 0, Structure::diagonal}, {0, 1, Structure::diagonal}, {1, 1, Structure::diagonal}};
}

Result EcefPv::propagate(const Step& step, const double* const* x, std::byte* /*memory*/,
                         const legacy::ProcessOutput& out) const {
  const double dt = step.dt;
  for (int i = 0; i < 3; ++i) out.x_plus[0][i] = x[0][i] + dt * x[1][i];
  std::copy_n(x[1], 3, out.x_plus[1]);
  std::fill_n(out.transition[0], 3, dt);
  std::fill_n(out.noise[0], 3, S_a_ * dt * dt * dt / 3 + S_v_ * dt);
  std::fill_n(out.noise[1], 3, S_a_ * dt * dt / 2);
  std::fill_n(out.noise[2], 3, S_a_ * dt);
  return Result::ok();
}

}  // namespace binnacle::gnss_range
