// SPDX-License-Identifier: Apache-2.0
// The way of a signal from a satellite to an antenna.
#include "gnss/signal_path.hpp"

#include <cmath>

#include "gnss/orbit.hpp"

namespace binnacle::gnss {

namespace {

using Eigen::Vector3d;

/// Components in axes that have turned with the earth by `angle`.
Vector3d turned(const Vector3d& v, double angle) {
  const double s = std::sin(angle), c = std::cos(angle);
  return {c * v.x() + s * v.y(), c * v.y() - s * v.x(), v.z()};
}

/// Its derivative by time: −ω × v.
Vector3d turning(const Vector3d& v) { return {omega_e * v.y(), -omega_e * v.x(), 0}; }

}  // namespace

SignalPath signal_path(const Vector3d& satellite, const Vector3d& antenna, bool with_rotation) {
  SignalPath path;
  path.satellite = satellite;
  path.range = (satellite - antenna).norm();
  if (with_rotation)
    for (int i = 0; i < 3; ++i) {  // contracts by ω r / c = 2e-6 each time
      path.satellite = turned(satellite, omega_e * path.range / speed_of_light);
      path.range = (path.satellite - antenna).norm();
    }
  path.direction = (path.satellite - antenna) / path.range;
  if (with_rotation) path.scale = 1 / (1 - path.direction.dot(turning(path.satellite)) / speed_of_light);
  return path;
}

RangeRate range_rate(const SignalPath& path, const Vector3d& satellite_velocity, const Vector3d& antenna_velocity,
                     bool with_rotation) {
  // ρ̇ = uᵀ (R v_s (1 − τ̇) + Ṙ r_s τ̇ − v_u) with τ̇ = ρ̇ / c, solved for ρ̇.
  Vector3d seen = satellite_velocity;
  double divisor = 1;
  if (with_rotation) {
    seen = turned(satellite_velocity, omega_e * path.range / speed_of_light);
    divisor += path.direction.dot(seen - turning(path.satellite)) / speed_of_light;
  }
  const Vector3d relative = seen - antenna_velocity;
  RangeRate result;
  result.rate = path.direction.dot(relative) / divisor;
  result.by_velocity = -path.direction.transpose() / divisor;
  result.by_position =
      -(relative - path.direction.dot(relative) * path.direction).transpose() * (path.scale / (path.range * divisor));
  return result;
}

Direction direction_in(const Eigen::Matrix3d& C_en, const Vector3d& direction) {
  const Vector3d ned = C_en.transpose() * direction;
  double azimuth = std::atan2(ned.y(), ned.x());
  if (azimuth < 0) azimuth += 2 * M_PI;
  return {azimuth, std::asin(std::fmax(-1.0, std::fmin(1.0, -ned.z())))};
}

}  // namespace binnacle::gnss
