// SPDX-License-Identifier: Apache-2.0
// The classical coning motion.
#include "coning_motion.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "simulation/quadrature.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::coning_simulator {

namespace {

constexpr double turn = 2.0 * std::numbers::pi;

}  // namespace

ConingMotion::ConingMotion(const Cone& cone, const Shaking& shaking, const std::optional<Eigen::Vector3d>& place)
    : cone_(cone),
      shaking_(shaking),
      place_(place),
      omega_(turn * cone.frequency),
      sin_half_(std::sin(0.5 * cone.half_angle)),
      cos_half_(std::cos(0.5 * cone.half_angle)),
      sin_cone_(std::sin(cone.half_angle)) {}

Eigen::Vector4d ConingMotion::attitude(double cycle) const {
  return {cos_half_, 0.0, sin_half_ * std::cos(turn * cycle), sin_half_ * std::sin(turn * cycle)};
}

Eigen::Matrix3d ConingMotion::C_nb(double cycle) const { return strapdown::dcm_from_quaternion(attitude(cycle)); }

Eigen::Vector3d ConingMotion::acceleration(double cycle) const {
  return std::cos(turn * cycle + shaking_.phase) * shaking_.amplitude;
}
Eigen::Vector3d ConingMotion::velocity(double cycle) const {
  return std::sin(turn * cycle + shaking_.phase) / omega_ * shaking_.amplitude;
}
Eigen::Vector3d ConingMotion::displacement(double cycle) const {
  return -std::cos(turn * cycle + shaking_.phase) / (omega_ * omega_) * shaking_.amplitude;
}
Eigen::Vector3d ConingMotion::position(double cycle) const {
  return strapdown::position_plus(*place_, displacement(cycle));
}

simulation::Inertial ConingMotion::beyond_the_cone(double cycle) const {
  const Eigen::Matrix3d C_bn = C_nb(cycle).transpose();
  if (!place_) return {Eigen::Vector3d::Zero(), C_bn * acceleration(cycle)};
  const Eigen::Vector3d lla = position(cycle), v_n = velocity(cycle);
  const Eigen::Vector3d omega_ie = strapdown::omega_ie_n(lla[0]);
  const Eigen::Vector3d omega_en = strapdown::omega_en_n(lla[0], lla[2], v_n);
  const Eigen::Vector3d gravity(0.0, 0.0, strapdown::gravity(lla[0], lla[2]).down);
  return {C_bn * (omega_ie + omega_en),
          C_bn * (acceleration(cycle) + (2.0 * omega_ie + omega_en).cross(v_n) - gravity)};
}

simulation::Inertial ConingMotion::increments(double middle, double length) const {
  const double swing = 2.0 * sin_cone_ * std::sin(0.5 * omega_ * length);
  simulation::Inertial sum{{-2.0 * omega_ * sin_half_ * sin_half_ * length, -swing * std::sin(turn * middle),
                            swing * std::cos(turn * middle)},
                           Eigen::Vector3d::Zero()};
  if (!place_ && shaking_.amplitude.isZero(0.0)) return sum;
  // Eight points over a radian are exact to 1e-17.
  const double pieces = std::ceil(omega_ * length);
  const double cycles = cone_.frequency * length / pieces;
  for (double piece = 0.0; piece < pieces; ++piece) {
    const double begin = middle + cycles * (piece - 0.5 * pieces);
    simulation::for_each_node<simulation::Gauss8>(begin, begin + cycles, [&](double cycle, double weight) {
      const simulation::Inertial rates = beyond_the_cone(cycle);
      sum.omega_ib_b += weight / cone_.frequency * rates.omega_ib_b;
      sum.f_b += weight / cone_.frequency * rates.f_b;
    });
  }
  return sum;
}

}  // namespace binnacle::coning_simulator
