// SPDX-License-Identifier: Apache-2.0
// The drive as functions of time.
#include "trajectory.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "profile.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::vehicle_simulator {

namespace {

using simulation::Angle;
using simulation::Gauss8;

// Limits of a piece that keep the collocation error of velocity below 1e-8 m/s.
constexpr double longest_piece = 20.0;  // s
constexpr double widest_piece = 0.2;    // rad of heading or slope
constexpr double pieces_of_a_ramp = 4;

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

Course course_along(const Segment& segment, double t) {
  const auto plateau = Plateau(seconds(segment.duration), segment.ramp).at(t - seconds(segment.begin));
  return {.speed = segment.speed + segment.acceleration * plateau.integral,
          .acceleration = segment.acceleration * plateau.value,
          .jerk = segment.acceleration * plateau.slope,
          .heading = Angle(segment.heading + segment.turn_rate * plateau.integral),
          .turn_rate = segment.turn_rate * plateau.value,
          .turn_acceleration = segment.turn_rate * plateau.slope,
          .slope = Angle(segment.slope * plateau.value),
          .slope_rate = segment.slope * plateau.slope};
}

Eigen::Vector3d velocity(const Course& c) {
  const double horizontal = c.speed * c.slope.cos;
  return {horizontal * c.heading.cos, horizontal * c.heading.sin, -c.speed * c.slope.sin};
}

Eigen::Vector3d velocity_derivative(const Course& c) {
  const double forward =
      c.acceleration * c.slope.cos - c.speed * c.slope.sin * c.slope_rate;  // of the horizontal speed
  const double sideways = c.speed * c.slope.cos * c.turn_rate;
  return {forward * c.heading.cos - sideways * c.heading.sin, forward * c.heading.sin + sideways * c.heading.cos,
          -c.acceleration * c.slope.sin - c.speed * c.slope.cos * c.slope_rate};
}

Eigen::Vector3d position_rate(const Eigen::Vector3d& lla, const Eigen::Vector3d& v_n) {
  const Angle lat(lla[0]);
  const strapdown::Radii r = strapdown::radii(lat.sin, lat.cos);
  return {v_n[0] / (r.meridian + lla[2]), v_n[1] / ((r.transverse + lla[2]) * lat.cos), -v_n[2]};
}

/// Times inside a segment where a derivative of its plateau may jump.
std::vector<double> segment_joints(const Segment& segment) {
  const double begin = seconds(segment.begin), end = seconds(segment.begin + segment.duration);
  if (segment.acceleration == 0.0 && segment.turn_rate == 0.0 && segment.slope == 0.0) return {begin, end};
  if (begin + segment.ramp >= end - segment.ramp) return {begin, begin + segment.ramp, end};
  return {begin, begin + segment.ramp, end - segment.ramp, end};
}

double abscissa(double t, double begin, double end) { return (2.0 * t - begin - end) / (end - begin); }

}  // namespace

Trajectory::Trajectory(const Start& start, std::vector<Segment> segments, const Suspension& suspension)
    : segments_(std::move(segments)), suspension_(suspension) {
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const auto joints = segment_joints(segments_[i]);
    for (std::size_t j = 0; j + 1 < joints.size(); ++j) add_pieces(i, joints[j], joints[j + 1]);
  }

  Eigen::Matrix<double, order, order> powers;
  for (int i = 0; i < order; ++i)
    for (int k = 0; k < order; ++k) powers(i, k) = std::pow(Gauss8::node[static_cast<std::size_t>(i)], k);
  const Eigen::Matrix<double, order, order> coefficients_of_values = powers.inverse();
  Eigen::Vector3d lla = start.lla;
  for (Piece& piece : pieces_) {
    piece.lla = lla;
    integrate(piece, coefficients_of_values);
    lla = position(piece, piece.end);
  }
}

void Trajectory::add_pieces(std::size_t segment, double begin, double end) {
  const Course first = course_along(segments_[segment], begin), last = course_along(segments_[segment], end);
  const double angle =
      std::abs(last.heading.value - first.heading.value) + std::abs(last.slope.value - first.slope.value);
  const bool is_ramp = first.turn_rate != last.turn_rate || first.slope.value != last.slope.value;
  const int count = static_cast<int>(
      std::ceil(std::max({is_ramp ? pieces_of_a_ramp : 1.0, (end - begin) / longest_piece, angle / widest_piece})));
  for (int i = 0; i < count; ++i) {
    Piece piece;
    piece.begin = begin + (end - begin) * i / count;
    piece.end = i + 1 == count ? end : begin + (end - begin) * (i + 1) / count;
    piece.segment = segment;
    pieces_.push_back(piece);
  }
}

/// Collocation: the polynomial whose derivative at the Gauss–Legendre points is the rate of position there
/// (order 16 at the ends). Rates depend on position only by v/R, so the fixed point contracts by 1e-4 or
/// better each time.
void Trajectory::integrate(Piece& piece, const Eigen::Matrix<double, order, order>& coefficients_of_values) const {
  constexpr int contractions = 6;
  const double half = 0.5 * (piece.end - piece.begin);
  for (int contraction = 0; contraction < contractions; ++contraction) {
    Eigen::Matrix<double, order, 3> rates;
    for (int i = 0; i < order; ++i) {
      const double t = piece.begin + half * (1.0 + Gauss8::node[static_cast<std::size_t>(i)]);
      rates.row(i) = position_rate(position(piece, t), velocity(course_along(segments_[piece.segment], t))).transpose();
    }
    const Eigen::Matrix<double, order, 3> coefficients = coefficients_of_values * rates;
    Eigen::Vector3d at_begin = Eigen::Vector3d::Zero();
    for (int k = 0; k < order; ++k) {
      piece.position.col(k + 1) = half / (k + 1) * coefficients.row(k).transpose();
      at_begin += (k % 2 == 0 ? -1.0 : 1.0) * piece.position.col(k + 1);
    }
    piece.position.col(0) = -at_begin;
  }
}

Eigen::Vector3d Trajectory::position(const Piece& piece, double t) const {
  const double x = abscissa(t, piece.begin, piece.end);
  Eigen::Vector3d sum = piece.position.col(order);
  for (int k = order - 1; k >= 0; --k) sum = sum * x + piece.position.col(k);
  return piece.lla + sum;
}

std::size_t Trajectory::piece_at(double t) const {
  const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), t,
                                      [](double time, const Piece& piece) { return time < piece.begin; });
  return after == pieces_.begin() ? 0 : static_cast<std::size_t>(after - pieces_.begin()) - 1;
}

Time Trajectory::duration() const { return segments_.back().begin + segments_.back().duration; }

Motion Trajectory::motion(double t) const {
  const double inside = std::clamp(t, pieces_.front().begin, pieces_.back().end);
  const Piece& piece = pieces_[piece_at(inside)];
  Motion m = motion(piece, course(piece, inside), inside);
  m.lla[1] = wrapped(m.lla[1]);
  m.roll_pitch_yaw[2] = wrapped(m.roll_pitch_yaw[2]);
  return m;
}

Course Trajectory::course(double t) const {
  const double inside = std::clamp(t, pieces_.front().begin, pieces_.back().end);
  return course(pieces_[piece_at(inside)], inside);
}

Course Trajectory::course(const Piece& piece, double t) const { return course_along(segments_[piece.segment], t); }

Motion Trajectory::motion(const Piece& piece, const Course& c, double t) const {
  Motion m;
  m.lla = position(piece, t);
  m.v_n = velocity(c);
  m.dv_n = velocity_derivative(c);
  m.roll_pitch_yaw << -suspension_.roll_gradient * c.speed * c.turn_rate,
      c.slope.value + suspension_.pitch_gradient * c.acceleration, c.heading.value;
  m.euler_rates << -suspension_.roll_gradient * (c.acceleration * c.turn_rate + c.speed * c.turn_acceleration),
      c.slope_rate + suspension_.pitch_gradient * c.jerk, c.turn_rate;
  return m;
}

Inertial Trajectory::increments(double t0, double t1) const {
  Inertial sum{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for_each_instant(t0, t1, [&](double /*t*/, double weight, const Motion& at, const Course& /*course*/) {
    const Inertial now = inertial(at);
    sum.omega_ib_b += weight * now.omega_ib_b;
    sum.f_b += weight * now.f_b;
  });
  return sum;
}

std::vector<double> Trajectory::joints() const {
  std::vector<double> all;
  for (const Segment& segment : segments_)
    for (const double t : segment_joints(segment))
      if (all.empty() || t > all.back()) all.push_back(t);
  return all;
}

double Trajectory::largest_latitude() const {
  double largest = std::abs(position(pieces_.back(), pieces_.back().end)[0]);
  for (const Piece& piece : pieces_) largest = std::max(largest, std::abs(piece.lla[0]));
  return largest;
}

}  // namespace binnacle::vehicle_simulator
