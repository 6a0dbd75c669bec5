// SPDX-License-Identifier: Apache-2.0
// The way of a vehicle that keeps its speed and its yaw rate.
#include "planar_arc.hpp"

#include <cmath>

namespace binnacle::odometry {

namespace {

/// sin u / u and its derivative.
struct Chord {
  double length, slope;
};
Chord chord(double u) {
  if (std::abs(u) < 1e-3) {  // the next terms are u⁶/5040 and u⁵/840
    const double u2 = u * u;
    return {1 - u2 / 6 + u2 * u2 / 120, -u / 3 + u * u2 / 30};
  }
  return {std::sin(u) / u, (u * std::cos(u) - std::sin(u)) / (u * u)};
}

}  // namespace

PlanarArc::PlanarArc(double yaw, double speed, double rate, double dt) {
  const double half = rate * dt / 2;
  const Chord c = chord(half);
  forward = {std::cos(yaw + half), std::sin(yaw + half)};
  by_speed = dt * c.length * forward;
  way = speed * by_speed;
  by_yaw = speed * dt * c.length * right();
  by_rate = speed * dt * dt / 2 * (c.slope * forward + c.length * right());
}

Eigen::Matrix3d arc_noise(const PlanarArc& arc, const PlanarNoise& noise, double speed, double dt) {
  const Eigen::Vector2d f = arc.forward, n = arc.right();
  const double across = noise.side * dt + noise.yaw * speed * speed * dt * dt * dt / 3;
  Eigen::Matrix3d Q;
  Q.topLeftCorner<2, 2>() = noise.speed * dt * f * f.transpose() + across * n * n.transpose();
  Q.topRightCorner<2, 1>() = noise.yaw * speed * dt * dt / 2 * n;
  Q.bottomLeftCorner<1, 2>() = Q.topRightCorner<2, 1>().transpose();
  Q(2, 2) = noise.yaw * dt;
  return Q;
}

}  // namespace binnacle::odometry
