// SPDX-License-Identifier: Apache-2.0
// A receiver that moves with nearly constant velocity, in north, east, down.
#include "ned_pv.hpp"

#include <Eigen/Core>

#include "strapdown/local_axes.hpp"

namespace binnacle::gnss_range {

ComponentSpec NedPv::spec() {
  using parameter::number;
  ComponentSpec spec;
  spec.type = "ned_pv";
  spec.summary =
      "Geodetic position and north, east, down velocity with white acceleration, for a receiver without inertial "
      "sensors.";
  spec.source = "paper 003, section 4.2, in local axes";
  spec.parameters = {
      number("S_a_horizontal", "m^2/s^3")
          .at_least(0)
          .required()
          .about("power spectral density of the north and the east acceleration, from the vehicle's manoeuvres"),
      number("S_a_vertical", "m^2/s^3")
          .at_least(0)
          .required()
          .about("power spectral density of the vertical acceleration; small for a road vehicle"),
      number("S_v", "m^2/s")
          .at_least(0)
          .defaults("0")
          .about("power spectral density of the white noise added to the velocity, in each direction")};
  spec.ports = {advances("position", "position").about("of the antenna"),
                advances("velocity", "velocity.ned").about("of the antenna")};
  spec.example =
      R"json({"blocks": {"position": "p", "velocity": "v"}, "S_a_horizontal": "1 m^2/s^3", "S_a_vertical": "0.01 m^2/s^3"})json";
  spec.surroundings = R"json({"blocks": {
    "p": {"type": "navigation/position", "init": {"lat": "52.5 deg", "lon": "13.4 deg", "height": "80 m"}, "sigma": "10 m"},
    "v": {"type": "navigation/velocity", "init": {"vn": 9, "ve": -4, "vd": 0.3}, "sigma": "1 m/s"}}})json";
  return spec;
}

NedPv::NedPv(const Binding& binding)
    : position_(binding.port("position")),
      velocity_(binding.port("velocity")),
      phi_pp_(declaration_.couples(position_, position_)),
      phi_pv_(declaration_.couples(position_, velocity_, Structure::diagonal)),
      q_pp_(declaration_.adds_noise(position_, position_, Structure::diagonal)),
      q_pv_(declaration_.adds_noise(position_, velocity_, Structure::diagonal)),
      q_vv_(declaration_.adds_noise(velocity_, velocity_, Structure::diagonal)),
      S_horizontal_(binding.parameters().number("S_a_horizontal")),
      S_vertical_(binding.parameters().number("S_a_vertical")),
      S_v_(binding.parameters().number("S_v")) {}

Result NedPv::propagate(const ProcessInput& in, ProcessOutput& out) const {
  const double dt = in.step.dt;
  const auto v = in.x[velocity_].as<3>();
  const strapdown::Advance advance = strapdown::advance(in.x[position_].as<3>(), dt * v);
  out.x[position_].as<3>() = advance.lla;
  out.x[velocity_].as<3>() = v;
  if (out.phi) {
    out.phi[phi_pp_].as<3, 3>() = advance.by_place;
    out.phi[phi_pv_].diagonal<3>() = dt * advance.by_way;
  }
  if (out.Qd) {
    const Eigen::Vector3d S(S_horizontal_, S_horizontal_, S_vertical_);
    out.Qd[q_pp_].diagonal<3>() = dt * dt * dt / 3 * S + Eigen::Vector3d::Constant(S_v_ * dt);
    out.Qd[q_pv_].diagonal<3>() = dt * dt / 2 * S;
    out.Qd[q_vv_].diagonal<3>() = dt * S;
  }
  return Result::ok();
}

}  // namespace binnacle::gnss_range
