// SPDX-License-Identifier: Apache-2.0
// A receiver that moves with nearly constant velocity: the GPS-only filter.
#include "ecef_pv.hpp"

#include <Eigen/Core>

#include "strapdown/earth.hpp"

namespace binnacle::gnss_range {

ComponentSpec EcefPv::spec() {
  ComponentSpec spec;
  spec.type = "ecef_pv";
  spec.summary = "Position and velocity in ECEF axes with white acceleration, for a receiver without inertial sensors.";
  spec.source = "paper 003, section 4.2";
  spec.parameters = {parameter::number("S_a", "m^2/s^3")
                         .at_least(0)
                         .about("power spectral density of the acceleration in each direction, from the vehicle's "
                                "manoeuvres; alternative to the next two"),
                     parameter::number("S_a_horizontal", "m^2/s^3")
                         .at_least(0)
                         .about("power spectral density of the north and the east acceleration"),
                     parameter::number("S_a_vertical", "m^2/s^3")
                         .at_least(0)
                         .about("power spectral density of the vertical acceleration; small for a road vehicle"),
                     parameter::number("S_v", "m^2/s")
                         .at_least(0)
                         .defaults("0")
                         .about("power spectral density of the white noise added to the velocity, a random walk of the "
                                "position; a large value makes every epoch independent")};
  spec.ports = {advances("position", "position.ecef").about("of the antenna"),
                advances("velocity", "velocity.ecef").about("of the antenna")};
  spec.example = R"json({"blocks": {"position": "r", "velocity": "v"}, "S_a": "0.12 m^2/s^3"})json";
  spec.surroundings = R"json({"blocks": {
    "r": {"type": "gnss_range/ecef_position", "init": {"x": -3976219, "y": 3382371, "z": 3652511}, "sigma": "10 m"},
    "v": {"type": "gnss_range/ecef_velocity", "init": {"vx": 0, "vy": 0, "vz": 0}, "sigma": "1 m/s"}}})json";
  return spec;
}

EcefPv::EcefPv(const Binding& binding) : position_(binding.port("position")), velocity_(binding.port("velocity")) {
  const Parameters& parameters = binding.parameters();
  const bool has_both = parameters.has("S_a_horizontal") && parameters.has("S_a_vertical");
  const bool has_some = parameters.has("S_a_horizontal") || parameters.has("S_a_vertical");
  if (parameters.has("S_a") == has_some || has_both != has_some)
    throw ComponentError("give 'S_a', or 'S_a_horizontal' and 'S_a_vertical'");
  is_isotropic_ = !has_both;
  S_a_ = parameters.number(has_both ? "S_a_horizontal" : "S_a");
  S_a_vertical_ = has_both ? parameters.number("S_a_vertical") : S_a_;
  S_v_ = parameters.number("S_v");
  const Structure structure = is_isotropic_ ? Structure::diagonal : Structure::dense;
  phi_pv_ = declaration_.couples(position_, velocity_, Structure::diagonal);
  q_pp_ = declaration_.adds_noise(position_, position_, structure);
  q_pv_ = declaration_.adds_noise(position_, velocity_, structure);
  q_vv_ = declaration_.adds_noise(velocity_, velocity_, structure);
}

Result EcefPv::propagate(const ProcessInput& in, ProcessOutput& out) const {
  const double dt = in.step.dt;
  const auto r = in.x[position_].as<3>();
  const auto v = in.x[velocity_].as<3>();
  out.x[position_].as<3>() = r + dt * v;
  out.x[velocity_].as<3>() = v;
  if (out.phi) out.phi[phi_pv_].diagonal<3>().setConstant(dt);
  if (!out.Qd) return Result::ok();
  if (is_isotropic_) {
    out.Qd[q_pp_].diagonal<3>().setConstant(S_a_ * dt * dt * dt / 3 + S_v_ * dt);
    out.Qd[q_pv_].diagonal<3>().setConstant(S_a_ * dt * dt / 2);
    out.Qd[q_vv_].diagonal<3>().setConstant(S_a_ * dt);
  } else {
    const Eigen::Vector3d lla = strapdown::lla_from_ecef(r);
    const Eigen::Vector3d up = -strapdown::C_en(lla[0], lla[1]).col(2);
    const Eigen::Matrix3d S = S_a_ * Eigen::Matrix3d::Identity() + (S_a_vertical_ - S_a_) * up * up.transpose();
    out.Qd[q_pp_].as<3, 3>() = dt * dt * dt / 3 * S + S_v_ * dt * Eigen::Matrix3d::Identity();
    out.Qd[q_pv_].as<3, 3>() = dt * dt / 2 * S;
    out.Qd[q_vv_].as<3, 3>() = dt * S;
  }
  return Result::ok();
}

}  // namespace binnacle::gnss_range
