// SPDX-License-Identifier: Apache-2.0
// What inertial sensors feel of a motion over the rotating earth.
#include "simulation/kinematics.hpp"

#include <Eigen/Geometry>

namespace binnacle::simulation {

Inertial inertial(const Motion& motion) {
  const Angle lat(motion.lla[0]);
  return inertial(motion, lat, strapdown::radii(lat.sin, lat.cos));
}

// Velocity equation v̇ = C_nb f − (2 ω_ie + ω_en) × v + g and attitude kinematics, solved for f and ω: P. D.
// Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., (5.53),
// (2.22), (2.58), (5.41).
Inertial inertial(const Motion& m, const Angle& lat, const strapdown::Radii& radii) {
  const Angle roll(m.roll_pitch_yaw[0]), pitch(m.roll_pitch_yaw[1]), yaw(m.roll_pitch_yaw[2]);
  const double height = m.lla[2];
  const double east_rate = m.v_n[1] / (radii.transverse + height);
  const Eigen::Vector3d omega_en(east_rate, -m.v_n[0] / (radii.meridian + height), -east_rate * lat.sin / lat.cos);
  const Eigen::Vector3d omega_ie(strapdown::wgs84::omega_ie * lat.cos, 0.0, -strapdown::wgs84::omega_ie * lat.sin);
  const Eigen::Vector3d gravity(0.0, 0.0, strapdown::gravity(lat.sin, lat.cos, height).down);
  const Eigen::Vector3d f_n = m.dv_n + (2.0 * omega_ie + omega_en).cross(m.v_n) - gravity;

  Eigen::Matrix3d C_bn;
  C_bn << pitch.cos * yaw.cos, pitch.cos * yaw.sin, -pitch.sin, roll.sin * pitch.sin * yaw.cos - roll.cos * yaw.sin,
      roll.sin * pitch.sin * yaw.sin + roll.cos * yaw.cos, roll.sin * pitch.cos,
      roll.cos * pitch.sin * yaw.cos + roll.sin * yaw.sin, roll.cos * pitch.sin * yaw.sin - roll.sin * yaw.cos,
      roll.cos * pitch.cos;
  const Eigen::Vector3d omega_nb_b(m.euler_rates[0] - pitch.sin * m.euler_rates[2],
                                   roll.cos * m.euler_rates[1] + roll.sin * pitch.cos * m.euler_rates[2],
                                   -roll.sin * m.euler_rates[1] + roll.cos * pitch.cos * m.euler_rates[2]);
  return {omega_nb_b + C_bn * (omega_ie + omega_en), C_bn * f_n};
}

}  // namespace binnacle::simulation
