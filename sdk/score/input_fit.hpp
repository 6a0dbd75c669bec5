// SPDX-License-Identifier: Apache-2.0
// Whether an inertial input shows the same motion as velocities over ground, and at the same time.
#pragma once

#include <Eigen/Core>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "input_history.hpp"
#include "linear_fit.hpp"

namespace binnacle::score {

/// The change of course is regressed on the turns of the three gyros, the changes of speed and the pull of curves on the
/// integrals of the three accelerometers, with the samples of velocity shifted in time by up to 20 s either way. None of
/// this needs an attitude: only that the sensor is fixed in a vehicle that moves ahead. Keeps sums, and a minute.
class InputFit {
 public:
  InputFit();

  void add_input(Time t0, Time t, const Turns& increment);
  void add_velocity(Time t, double north, double east);
  void exchange(StateBytes& bytes);

  /// By how much the samples of velocity are labelled too late for the input; negative: too early.
  struct Shift {
    double seconds = 0, sigma = 0;
  };
  /// If it is significant.
  std::optional<Shift> shift() const;
  /// The motion along the axes of the input, at the best shift.
  struct Axes {
    LinearFit<4> turn;          // of the course, to the right, over the gyros' integrals and time
    LinearFit<2> vertical;      // the same over the turn about the vertical of the accelerometers, and time
    LinearFit<4> ahead, aside;  // gain of speed, and pull of curves to the right, over the accelerometers' and time
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  // mean over all
    double seconds = 0;                               // of the input
  };
  Axes axes() const;

  /// All that is known, in numbers.
  std::string figures() const;

 private:
  /// From one sample of velocity to another.
  struct Leg {
    Time from = no_time, to = no_time;
    double turn = 0, faster = 0, speed = 0;  // rad, m/s, the mean m/s
  };
  /// Of one shift: rows are the three integrals and the time.
  struct Sums {
    Eigen::Matrix4d gyro = Eigen::Matrix4d::Zero(), accel = Eigen::Matrix4d::Zero();  // lower triangles
    Eigen::Vector4d turn = Eigen::Vector4d::Zero(), ahead = Eigen::Vector4d::Zero(), aside = Eigen::Vector4d::Zero();
  };
  static constexpr int most_steps = 200;  // of shift, either way
  static constexpr std::size_t shifts = 2 * most_steps + 1;
  using Misfits = std::array<double, shifts>;
  struct Minimum {
    double seconds = 0, sigma = 0, gain = 0;  // over no shift; sigma 0: there is none
  };
  struct Best;
  void work_off();
  void take(const Leg& leg);
  Misfits misfits(const Eigen::Matrix4d Sums::*products, const Eigen::Vector4d Sums::*with, double squares) const;
  static Minimum minimum(const Misfits& misfits, std::size_t near);
  Best best() const;

  InputHistory history_;
  std::vector<Leg> waiting_;  // a ring
  std::size_t first_ = 0, waiting_count_ = 0;
  Time last_ = no_time;
  double north_ = 0, east_ = 0;
  std::vector<Sums> sums_;  // by shift
  double turn2_ = 0, ahead2_ = 0, aside2_ = 0, speed_sum_ = 0, count_ = 0;
};

}  // namespace binnacle::score
