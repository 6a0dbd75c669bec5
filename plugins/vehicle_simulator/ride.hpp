// SPDX-License-Identifier: Apache-2.0
// The ride: how the body moves against the path that it drives.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "segments.hpp"
#include "spline_noise.hpp"
#include "trajectory.hpp"

namespace binnacle::vehicle_simulator {

/// Standard deviations; all zero: the body keeps to its path.
struct RideModel {
  double slip = 0;                               // rad per m/s² of lateral acceleration
  double sway = 0, heave = 0;                    // m/s, velocity to the right, down
  double rocking = 0;                            // m/s, forward, right, down
  double roll = 0, pitch = 0;                    // rad
  double frequency = 1.5;                        // Hz
  double half_speed = 1;                         // m/s
  double boarding_every = 0;                     // s; 0: nobody boards
  double boarding_after = 0;                     // s from the start
  double boarding_duration = 1;                  // s
  double boarding_heave = 0;                     // m
  double boarding_roll = 0, boarding_pitch = 0;  // rad
};

/// What it remembers of the last question; plain memory.
struct RideMemory {
  SplineMemory sway, heave, roll, pitch, rocking[3];
  random::Philox boarding;  // at its beginning
  std::int64_t event;       // number of the boarding below; −1: none yet
  double event_begin;       // s
  double event_size[3];     // heave m, roll rad, pitch rad
};

/// Sway, heave, roll and pitch of the driving body are SplineNoise times g(v) = v/√(v² + half_speed²); sway and heave
/// are of the path's point, sideways and down, roll and pitch are turns about it. Rocking is 1 − g(v) of a motion in all
/// three directions, of a vehicle that stands in the wind. While it stands people board: a push of heave, roll and pitch
/// shaped 64 τ³(1−τ)³, one in each `boarding_every` seconds of a stop.
class Ride {
 public:
  Ride(const RideModel& model, const std::vector<Segment>& segments);

  bool is_still() const { return is_still_; }
  static RideMemory start(std::uint64_t seed);
  /// `motion` of the path at t [s] and `course` → that of the body.
  void apply(double t, const Course& course, Motion& motion, RideMemory& memory) const;
  /// g(v), 0 … 1.
  double share(double speed) const;

 private:
  struct Stop {
    double begin, end;   // s
    std::int64_t first;  // number of its first boarding
  };

  void displace(double t, const Course& course, Motion& motion, RideMemory& memory) const;
  void lean(double t, const Course& course, Motion& motion, RideMemory& memory) const;
  void board(double t, Motion& motion, RideMemory& memory) const;

  RideModel model_;
  bool is_still_, drives_, rocks_, boards_;
  SplineNoise noise_;
  std::vector<Stop> stops_;
};

}  // namespace binnacle::vehicle_simulator
