// SPDX-License-Identifier: Apache-2.0
// The drive as functions of time: position, velocity, attitude, and what an inertial sensor would feel.
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "segments.hpp"
#include "simulation/kinematics.hpp"
#include "simulation/quadrature.hpp"

namespace binnacle::vehicle_simulator {

struct Start {
  Eigen::Vector3d lla = Eigen::Vector3d::Zero();  // latitude rad, longitude rad, height m
};

/// How the body leans on its springs: rad per m/s².
struct Suspension {
  double roll_gradient = 0.0;   // away from the turn, per lateral acceleration
  double pitch_gradient = 0.0;  // nose up, per acceleration along the path
};

using simulation::Inertial;
using simulation::Motion;

/// Speed, heading and slope along the path with their derivatives by time.
struct Course {
  double speed, acceleration, jerk;
  simulation::Angle heading;
  double turn_rate, turn_acceleration;
  simulation::Angle slope;
  double slope_rate;
};

/// Immutable. Speed, heading and slope are closed functions of time (Plateau). Position is the integral of
/// velocity over the ellipsoid by collocation at eight Gauss–Legendre points, kept as a polynomial per piece;
/// pieces are short enough that its derivative is the velocity to 1e-8 m/s. So a position depends on time
/// alone, not on who asked for which instants before. Times are seconds from the start of the drive; outside
/// they are taken to the nearest end.
class Trajectory {
 public:
  Trajectory(const Start& start, std::vector<Segment> segments, const Suspension& suspension);

  Time duration() const;
  Motion motion(double t) const;
  Course course(double t) const;
  /// ∫ ω_ib_b dt and ∫ f_b dt over [t0, t1] (rad, m/s): five-point Gauss–Legendre quadrature, cut at the
  /// joints of the manoeuvres' ramps, so that every integrand is smooth.
  Inertial increments(double t0, double t1) const;
  /// The quadrature of increments(): calls visit(t, weight, motion, course) at its abscissae.
  template <class Visit>
  void for_each_instant(double t0, double t1, Visit&& visit) const {
    double t = t0;
    for (std::size_t i = piece_at(t0); t < t1 && i < pieces_.size(); ++i) {
      const double end = i + 1 == pieces_.size() ? t1 : std::min(pieces_[i].end, t1);
      simulation::for_each_node<simulation::Gauss5>(t, end, [&](double at, double weight) {
        const Course c = course(pieces_[i], at);
        visit(at, weight, motion(pieces_[i], c, at), c);
      });
      t = end;
    }
  }
  /// Instants between which everything is infinitely differentiable.
  std::vector<double> joints() const;
  /// The largest |latitude| on the way, rad.
  double largest_latitude() const;

 private:
  static constexpr int order = 8;

  struct Piece {
    double begin = 0.0, end = 0.0;
    std::size_t segment = 0;
    Eigen::Vector3d lla = Eigen::Vector3d::Zero();  // at begin
    // lla − (lla at begin), by powers of x ∈ [−1, 1] over the piece
    Eigen::Matrix<double, 3, order + 1> position = Eigen::Matrix<double, 3, order + 1>::Zero();
  };

  void add_pieces(std::size_t segment, double begin, double end);
  void integrate(Piece& piece, const Eigen::Matrix<double, order, order>& coefficients_of_values) const;
  std::size_t piece_at(double t) const;
  Eigen::Vector3d position(const Piece& piece, double t) const;
  Course course(const Piece& piece, double t) const;
  Motion motion(const Piece& piece, const Course& c, double t) const;

  std::vector<Segment> segments_;
  std::vector<Piece> pieces_;
  Suspension suspension_;
};

}  // namespace binnacle::vehicle_simulator
