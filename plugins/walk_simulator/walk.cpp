// SPDX-License-Identifier: Apache-2.0
#include "walk.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulation/quadrature.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::walk_simulator {

namespace {

using Eigen::Vector3d;

/// A function of τ and its derivatives by τ.
using Shape = Vector3d;

Shape smooth_step(double tau) {
  return {tau * tau * tau * (10.0 + tau * (-15.0 + 6.0 * tau)), 30.0 * tau * tau * (1.0 - tau) * (1.0 - tau),
          60.0 * tau * (1.0 - tau) * (1.0 - 2.0 * tau)};
}

/// τᵃ (1 − τ)ᵇ over its largest value, which it has at a/(a + b).
Shape bump(double tau, int a, int b) {
  const double peak = static_cast<double>(a) / (a + b), left = 1.0 - tau;
  const double scale = 1.0 / (std::pow(peak, a) * std::pow(1.0 - peak, b));
  const double inner = scale * std::pow(tau, a - 2) * std::pow(left, b - 2);
  const double slope = a * left - b * tau;
  return {inner * tau * tau * left * left, inner * tau * left * slope,
          inner * (slope * slope - a * left * left - b * tau * tau)};
}

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

}  // namespace

Walk::Walk(const Vector3d& start, double heading, const Gait& gait, const std::vector<Leg>& legs)
    : start_(start), gait_(gait) {
  const simulation::Angle lat(start[0]);
  const strapdown::Radii radii = strapdown::radii(lat.sin, lat.cos);
  north_radius_ = radii.meridian + start[2];
  east_radius_ = (radii.transverse + start[2]) * lat.cos;
  Vector3d at = Vector3d::Zero();
  for (const Leg& leg : legs) {
    if (leg.strides == 0) {
      strides_.push_back({duration_, at, heading, 0, 0, 0});
      duration_ += leg.duration;
    }
    for (int i = 0; i < leg.strides; ++i) {
      const double turn = leg.turn / leg.strides, climb = leg.climb / leg.strides;
      strides_.push_back({duration_, at, heading, turn, climb, gait.stride});
      joints_.push_back(duration_);
      joints_.push_back(duration_ + gait.swing);
      const double chord = heading + 0.5 * turn;
      at += Vector3d(gait.stride * std::cos(chord), gait.stride * std::sin(chord), -climb);
      heading += turn;
      duration_ += gait.cycle;
    }
  }
  strides_.push_back({duration_, at, heading, 0, 0, 0});
}

std::size_t Walk::stride_at(double t) const {
  const auto after = std::upper_bound(strides_.begin(), strides_.end(), t,
                                      [](double time, const Stride& stride) { return time < stride.begin; });
  return after == strides_.begin() ? 0 : static_cast<std::size_t>(after - strides_.begin()) - 1;
}

bool Walk::is_standing(double t) const {
  const Stride& stride = strides_[stride_at(t)];
  return !(stride.distance > 0) || t <= stride.begin || t >= stride.begin + gait_.swing;
}

Walk::Foot Walk::foot(double t) const {
  const Stride& stride = strides_[stride_at(t)];
  Foot foot;
  foot.place.col(0) = stride.at;
  foot.angles(1, 0) = stride.heading;
  if (!(stride.distance > 0)) return foot;
  const double tau = std::clamp((t - stride.begin) / gait_.swing, 0.0, 1.0);
  const Vector3d by_time(1.0, 1.0 / gait_.swing, 1.0 / (gait_.swing * gait_.swing));
  const Shape step = smooth_step(tau).cwiseProduct(by_time), middle = bump(tau, 3, 3).cwiseProduct(by_time);
  const Shape early = bump(tau, 3, 6).cwiseProduct(by_time), late = bump(tau, 6, 3).cwiseProduct(by_time);
  const double chord = stride.heading + 0.5 * stride.turn, cos = std::cos(chord), sin = std::sin(chord);
  const Shape along = stride.distance * step, right = gait_.outward * middle;
  foot.place.row(0) += (cos * along - sin * right).transpose();
  foot.place.row(1) += (sin * along + cos * right).transpose();
  foot.place.row(2) -= (stride.climb * step + gait_.lift * middle).transpose();
  foot.angles.row(0) = (gait_.heel_strike * late - gait_.toe_off * early).head<2>().transpose();
  foot.angles.row(1) += (stride.turn * step).head<2>().transpose();
  return foot;
}

// Latitude and longitude go by the metres per radian of the start, so that the path is a closed function; the velocity over
// ground is that of the ellipsoid where the foot is, with the derivatives of the radii.
simulation::Motion Walk::motion(double t) const {
  const Foot now = foot(t);
  const double lat_rate = now.place(0, 1) / north_radius_, lon_rate = now.place(1, 1) / east_radius_;
  const double lat_acceleration = now.place(0, 2) / north_radius_, lon_acceleration = now.place(1, 2) / east_radius_;
  simulation::Motion m;
  m.lla << start_[0] + now.place(0, 0) / north_radius_, wrapped(start_[1] + now.place(1, 0) / east_radius_),
      start_[2] - now.place(2, 0);
  const simulation::Angle lat(m.lla[0]);
  const strapdown::Radii radii = strapdown::radii(lat.sin, lat.cos);
  const double flat = 1.0 - strapdown::wgs84::e2 * lat.sin * lat.sin;
  const double meridian_rate = 3.0 * radii.meridian * strapdown::wgs84::e2 * lat.sin * lat.cos / flat * lat_rate;
  const double transverse_rate = radii.transverse * strapdown::wgs84::e2 * lat.sin * lat.cos / flat * lat_rate;
  const double climb_rate = -now.place(2, 1);
  const double to_north = radii.meridian + m.lla[2], to_axis = radii.transverse + m.lla[2];
  m.v_n << to_north * lat_rate, to_axis * lat.cos * lon_rate, now.place(2, 1);
  m.dv_n << to_north * lat_acceleration + (meridian_rate + climb_rate) * lat_rate,
      to_axis * lat.cos * lon_acceleration +
          ((transverse_rate + climb_rate) * lat.cos - to_axis * lat.sin * lat_rate) * lon_rate,
      now.place(2, 2);
  m.roll_pitch_yaw << 0.0, now.angles(0, 0), wrapped(now.angles(1, 0));
  m.euler_rates << 0.0, now.angles(0, 1), now.angles(1, 1);
  return m;
}

simulation::Inertial Walk::increments(double t0, double t1) const {
  simulation::Inertial sum{Vector3d::Zero(), Vector3d::Zero()};
  auto joint = std::upper_bound(joints_.begin(), joints_.end(), t0);
  for (double t = t0; t < t1;) {
    const double end = joint == joints_.end() ? t1 : std::min(*joint++, t1);
    simulation::for_each_node<simulation::Gauss8>(t, end, [&](double at, double weight) {
      const simulation::Inertial now = simulation::inertial(motion(at));
      sum.omega_ib_b += weight * now.omega_ib_b;
      sum.f_b += weight * now.f_b;
    });
    t = end;
  }
  return sum;
}

}  // namespace binnacle::walk_simulator
