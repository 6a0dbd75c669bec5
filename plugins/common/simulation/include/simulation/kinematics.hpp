// SPDX-License-Identifier: Apache-2.0
// What inertial sensors feel of a motion over the rotating earth.
#pragma once

#include <cmath>

#include <Eigen/Core>

#include "strapdown/earth.hpp"

namespace binnacle::simulation {

/// An angle that is used with its sine and cosine.
struct Angle {
  explicit Angle(double radians) : value(radians), sin(std::sin(radians)), cos(std::cos(radians)) {}
  double value, sin, cos;
};

/// All in navigation axes (NED) at one instant.
struct Motion {
  Eigen::Vector3d lla;             // latitude rad, longitude rad in [−π, π], height m
  Eigen::Vector3d v_n;             // velocity over ground, m/s
  Eigen::Vector3d dv_n;            // its time derivative by components, m/s²
  Eigen::Vector3d roll_pitch_yaw;  // rad; yaw in [−π, π]
  Eigen::Vector3d euler_rates;     // rad/s
};

struct Inertial {
  Eigen::Vector3d omega_ib_b;  // rad/s
  Eigen::Vector3d f_b;         // m/s²
};

/// ω_ib_b and f_b by inversion of the navigation equations at `motion`; no mechanization is involved.
Inertial inertial(const Motion& motion);
/// The same when the latitude's sine and cosine and the radii of curvature there are at hand.
Inertial inertial(const Motion& motion, const Angle& lat, const strapdown::Radii& radii);

}  // namespace binnacle::simulation
