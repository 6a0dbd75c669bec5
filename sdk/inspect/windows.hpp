// SPDX-License-Identifier: Apache-2.0
// Windows of some seconds in which velocities and inertial samples are brought together without a filter: the rates carry
// an attitude from the window's begin, and one rotation (Wahba's problem, by SVD) has to turn all sums of specific force into
// the differences of velocity less gravity. What is left measures how well rates, forces, axes and clocks go together.
#pragma once

#include <cstddef>
#include <vector>

#include "series.hpp"
#include "statistics.hpp"

namespace binnacle::inspect {

class Windows {
 public:
  /// delay: a fix at label t belongs to t - delay of the IMU. near: what the antenna's motion at a fix is a mean over, on both sides [s].
  Windows(const Inertial& inertial, const Fixes& fixes, double delay, double length, double near = 0.1);
  /// From the sensor to the antenna, in the sensor's axes [m]; follow() then takes its motion off.
  void set_lever_arm(const Vector3d& lever_arm) { lever_arm_ = lever_arm; }

  std::size_t size() const { return windows_.size(); }
  double from(std::size_t window) const { return intervals_[windows_[window].first].from; }
  double to(std::size_t window) const { return intervals_[windows_[window].end - 1].to; }
  double top_speed(std::size_t window) const { return windows_[window].top_speed; }

  /// Log-likelihoods, negative, of one window with rates X (w - bias), for triads of force that are right-handed and for those
  /// that are not (whose components are all negated, which makes them right-handed).
  struct Cost {
    double plus, minus;
  };
  Cost cost(std::size_t window, const Matrix3d& X, const Vector3d& bias) const;

  /// With the rates as they are: by interval, attitude C_nb at its end and what is left of the velocity's difference.
  struct Step {
    double t;         // s, label of the fix
    Vector3d v;       // at its end
    Matrix3d C_nb;    // at its end
    Vector3d left;    // m/s
    double doubt;     // how much less certain than usual the receiver states its velocity to be, at least 1
    Vector3d rate_b;  // mean near its end, less bias [rad/s]
    Vector3d rate_begin;
    Matrix3d C_begin;
    double sink;    // difference of the velocity down, as the receiver has it [m/s]
    Vector3d push;  // sum of specific force, turned: what the difference of velocity less gravity is to be [m/s]
    Vector3d force_b = Vector3d::Zero(), force_begin = Vector3d::Zero();  // as the rates [m/s^2]
  };
  std::vector<Step> follow(std::size_t window, const Vector3d& bias) const;

 private:
  struct Piece {
    Vector3d turn, push;  // integrals of rate and force
    double dt;
  };
  struct Interval {
    double from, to;
    double doubt;            // of the less certain end
    Vector3d u, v;           // difference of velocity less gravity; velocity at the end
    std::size_t first, end;  // pieces
    double sink = 0;
    Vector3d rate_begin, rate_end, force_begin, force_end;  // means near both ends
  };
  struct Window {
    std::size_t first, end;
    double top_speed;
  };
  void cut(double length, double least_speed);

  Vector3d lever_arm_ = Vector3d::Zero();
  std::vector<Piece> pieces_;
  std::vector<Interval> intervals_;
  std::vector<bool> follows_;  // the interval before
  std::vector<Window> windows_;
};

/// [a x]: cross_matrix(a) b = a x b.
Matrix3d cross_matrix(const Vector3d& a);
/// Takes out of rows, and of what is left, what a window's own unknowns (the columns of of_window) explain (Frisch and Waugh).
void project_out(const Eigen::MatrixXd& of_window, Eigen::Ref<Eigen::MatrixXd> rows, Eigen::Ref<Eigen::VectorXd> left);

/// What turning adds to the differences of velocity, in the sensor's axes [m]. A small rotation of each window is fitted with it, for
/// its attitude has taken part of the lever arm up; the fit is repeated with what was found taken off, which it leaves set.
LinearFit lever_arm_of(Windows& windows, const Vector3d& bias, int passes);

}  // namespace binnacle::inspect
