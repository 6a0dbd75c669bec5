// SPDX-License-Identifier: Apache-2.0
// The ship as a rigid body over the rotating earth: exact functions of time.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "simulation/kinematics.hpp"
#include "waves.hpp"

namespace binnacle::ship_simulator {

struct Course {
  Eigen::Vector3d lla = Eigen::Vector3d::Zero();  // of the MINS at the start, without waves
  double speed = 0.0;                             // m/s at the start
  double heading = 0.0;                           // rad
  double roll = 0.0, pitch = 0.0;                 // rad, mean
};

/// The MINS at one instant, with derivatives by time.
struct State {
  Eigen::Vector3d lla, lla_rate, lla_acceleration;
  Eigen::Vector3d euler, euler_rate, euler_acceleration;  // roll, pitch, yaw
};

/// What a sensor triad at a point of the ship shows and feels.
struct Point {
  Eigen::Vector3d lla;
  Eigen::Vector3d v_n;   // m/s, in navigation axes at the point
  Eigen::Vector4d q_nm;  // ship (MINS body) axes to navigation axes at the point
};

/// Immutable. With the displacements N, E, D of surge, sway, heave and the way made good,
///     lat = lat₀ + N/(R_m + h₀),  lon = lon₀ + E/((R_t + h₀) cos lat₀),  h = h₀ − D          radii at lat₀,
/// so positions, velocities, accelerations are closed functions of time, consistent with the ellipsoid exactly. The mean
/// course is a straight line in latitude and longitude: the velocity in m/s is the one that belongs to it, `speed` at the
/// start and changing by parts in 1e4 over tens of kilometres.
/// `phases` has one element per tone, in the order of the degrees of freedom. Times are seconds from the start.
class ShipMotion {
 public:
  ShipMotion(const Course& course, const std::array<std::vector<Tone>, freedoms>& tones);

  const std::array<std::vector<Tone>, freedoms>& tones() const { return tones_; }
  std::size_t tone_count() const;
  double largest_omega() const;

  State at(double t, const double* phases) const;
  /// At middle − offset and middle + offset; faster than one by one. largest_omega() · offset must be below 0.05.
  std::array<State, 2> around(double middle, double offset, const double* phases) const;

 private:
  struct Waves {
    std::array<double, freedoms> value{}, rate{}, acceleration{};
  };
  State state(double t, const Waves& waves) const;

  Course course_;
  std::array<std::vector<Tone>, freedoms> tones_;
  double sin_heading_, cos_heading_;
  double north_to_lat_, east_to_lon_;  // rad/m
};

simulation::Motion motion(const State& state);

/// Position, velocity and attitude at the end of `lever_arm` (m, ship axes) from the MINS. Rigid, exactly.
Point at_lever_arm(const State& state, const Eigen::Vector3d& lever_arm);

/// Angular rate and specific force there, in ship axes.
simulation::Inertial inertial_at_lever_arm(const State& state, const Eigen::Vector3d& lever_arm);

/// q_im: ship axes to axes that do not rotate and are those of the earth at t = 0.
Eigen::Vector4d inertial_attitude(const State& state, double t);

}  // namespace binnacle::ship_simulator
