// SPDX-License-Identifier: Apache-2.0
// A receiver that moves with nearly constant velocity: the GPS-only filter.
#include "ecef_pv.hpp"

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
  spec.ports = {advances("position", "position.ecef").about("of the antenna"),
                advances("velocity", "velocity.ecef").about("of the antenna")};
  spec.example = R"json({"blocks": {"position": "r", "velocity": "v"}, "S_a": "0.12 m^2/s^3"})json";
  spec.surroundings = R"json({"blocks": {
    "r": {"type": "gnss_range/ecef_position", "init": {"x": -3976219, "y": 3382371, "z": 3652511}, "sigma": "10 m"},
    "v": {"type": "gnss_range/ecef_velocity", "init": {"vx": 0, "vy": 0, "vz": 0}, "sigma": "1 m/s"}}})json";
  return spec;
}

EcefPv::EcefPv(const Binding& binding)
    : position_(binding.port("position")),
      velocity_(binding.port("velocity")),
      phi_pv_(declaration_.couples(position_, velocity_, Structure::diagonal)),
      q_pp_(declaration_.adds_noise(position_, position_, Structure::diagonal)),
      q_pv_(declaration_.adds_noise(position_, velocity_, Structure::diagonal)),
      q_vv_(declaration_.adds_noise(velocity_, velocity_, Structure::diagonal)),
      S_a_(binding.parameters().number("S_a")),
      S_v_(binding.parameters().number("S_v")) {}

Result EcefPv::propagate(const ProcessInput& in, ProcessOutput& out) const {
  const double dt = in.step.dt;
  const auto v = in.x[velocity_].as<3>();
  out.x[position_].as<3>() = in.x[position_].as<3>() + dt * v;
  out.x[velocity_].as<3>() = v;
  if (out.phi) out.phi[phi_pv_].diagonal<3>().setConstant(dt);
  if (out.Qd) {
    out.Qd[q_pp_].diagonal<3>().setConstant(S_a_ * dt * dt * dt / 3 + S_v_ * dt);
    out.Qd[q_pv_].diagonal<3>().setConstant(S_a_ * dt * dt / 2);
    out.Qd[q_vv_].diagonal<3>().setConstant(S_a_ * dt);
  }
  return Result::ok();
}

}  // namespace binnacle::gnss_range
