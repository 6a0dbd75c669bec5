// SPDX-License-Identifier: Apache-2.0
// The way of a vehicle that keeps its speed and its yaw rate: an arc in the horizontal plane, and its derivatives.
#pragma once

#include <Eigen/Core>

namespace binnacle::odometry {

/// Over dt at speed v and yaw rate ω, from heading ψ: with θ = ω dt, ψ_m = ψ + θ/2 and D = v dt sin(θ/2)/(θ/2), the chord,
///     north = D cos ψ_m        east = D sin ψ_m.
/// Exact where v and ω are constant (Borenstein et al., Navigating Mobile Robots, 1996, section 1.3, has the first order).
struct PlanarArc {
  Eigen::Vector2d way;      // m, north, east
  Eigen::Vector2d forward;  // unit vector along the chord
  Eigen::Vector2d by_yaw, by_rate, by_speed;

  PlanarArc(double yaw, double speed, double rate, double dt);
  /// To the right of the chord.
  Eigen::Vector2d right() const { return {-forward[1], forward[0]}; }
};

/// Densities of what drives it.
struct PlanarNoise {
  double speed = 0;  // m²/s, along
  double side = 0;   // m²/s, across
  double yaw = 0;    // rad²/s
};

/// Covariance of (north, east, yaw) after the arc, from white noise in speed, slip and yaw rate. The direction is taken as
/// that of the chord throughout: with n = right(), f = forward,
///     Q_pp = S_f dt f fᵀ + (S_s dt + S_ψ v² dt³/3) n nᵀ        Q_pψ = S_ψ v dt²/2 n        Q_ψψ = S_ψ dt,
/// which leaves out terms of relative order θ.
Eigen::Matrix3d arc_noise(const PlanarArc& arc, const PlanarNoise& noise, double speed, double dt);

}  // namespace binnacle::odometry
