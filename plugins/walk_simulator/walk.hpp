// SPDX-License-Identifier: Apache-2.0
// The path of a foot as functions of time: it swings, and stands still in between.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "simulation/kinematics.hpp"

namespace binnacle::walk_simulator {

/// How one foot goes.
struct Gait {
  double stride = 0;       // m, from one of its footprints to the next
  double cycle = 0;        // s, a swing and the stance after it
  double swing = 0;        // s
  double lift = 0;         // m, of the sole in mid-swing
  double outward = 0;      // m, to the right in mid-swing
  double toe_off = 0;      // rad, toes down, early in the swing
  double heel_strike = 0;  // rad, toes up, late in it
};

/// Strides that are alike, or a time of standing.
struct Leg {
  int strides = 0;      // 0: it stands
  double duration = 0;  // s, of standing
  double turn = 0;      // rad, of the heading, over all strides
  double climb = 0;     // m, over all strides
};

/// Immutable. With τ from 0 to 1 over a swing and S(τ) = τ³ (10 − 15 τ + 6 τ²), the foot goes by S along the chord of its
/// turn, by S up the stairs and by S about the vertical; lift, way outward and pitch are bumps τᵃ (1 − τ)ᵇ, a, b ≥ 3. So
/// position and attitude are closed functions of time whose first two derivatives are zero in a stance, where velocity and
/// angular rate against the earth are zero to the bit. Times are seconds from the begin; outside, the foot stands.
class Walk {
 public:
  /// start: latitude rad, longitude rad, height m of the foot's sensor; heading rad.
  Walk(const Eigen::Vector3d& start, double heading, const Gait& gait, const std::vector<Leg>& legs);

  double duration() const { return duration_; }
  simulation::Motion motion(double t) const;
  bool is_standing(double t) const;
  /// ∫ ω_ib_b dt [rad] and ∫ f_b dt [m/s] over [t0, t1]: Gauss–Legendre quadrature, cut where a swing begins or ends.
  simulation::Inertial increments(double t0, double t1) const;

 private:
  /// Begin of a swing, or of standing for good.
  struct Stride {
    double begin = 0;                                       // s
    Eigen::Vector3d at = Eigen::Vector3d::Zero();           // north, east, down [m] from the start
    double heading = 0, turn = 0, climb = 0, distance = 0;  // rad, rad, m, m
  };
  /// North, east, down [m], and pitch, yaw [rad], with derivatives by time.
  struct Foot {
    Eigen::Matrix<double, 3, 3> place = Eigen::Matrix3d::Zero();               // columns: value, first, second
    Eigen::Matrix<double, 2, 2> angles = Eigen::Matrix<double, 2, 2>::Zero();  // rows pitch, yaw; value, first
  };
  std::size_t stride_at(double t) const;
  Foot foot(double t) const;

  Eigen::Vector3d start_;
  double north_radius_, east_radius_;  // m, metres per radian of latitude and of longitude at the start
  Gait gait_;
  std::vector<Stride> strides_;
  std::vector<double> joints_;
  double duration_ = 0;
};

}  // namespace binnacle::walk_simulator
