// SPDX-License-Identifier: Apache-2.0
// The way of a signal from a satellite to an antenna: range, direction, and how they change.
#pragma once

#include <Eigen/Core>

namespace binnacle::gnss {

/// In ECEF axes of the instant of reception. Paper 003 has the line of sight from satellite to user: l = −direction.
struct SignalPath {
  double range = 0;                                     // m
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit vector from the antenna to the satellite
  Eigen::Vector3d satellite = Eigen::Vector3d::Zero();  // m, where the satellite was, turned into these axes
  /// ∂range/∂antenna = −scale directionᵀ. The light's time changes with the range, and so does the earth's turn: scale
  /// differs from 1 by 1e-6.
  double scale = 1;
};

/// From the satellite's position at transmission, in axes of that instant. with_rotation: the earth turns by ω τ while
/// the signal travels for τ = range / c (iterated; the Sagnac effect).
SignalPath signal_path(const Eigen::Vector3d& satellite, const Eigen::Vector3d& antenna, bool with_rotation);

/// Rate of the range and its derivatives. Without rotation it is paper 003 (7): (v_u − v_i)ᵀ l.
struct RangeRate {
  double rate = 0;                 // m/s
  Eigen::RowVector3d by_velocity;  // ∂/∂v of the antenna
  Eigen::RowVector3d by_position;  // ∂/∂r of the antenna, 1/s
};
RangeRate range_rate(const SignalPath& path, const Eigen::Vector3d& satellite_velocity,
                     const Eigen::Vector3d& antenna_velocity, bool with_rotation);

struct Direction {
  double azimuth = 0;    // rad, clockwise from north, 0 … 2π
  double elevation = 0;  // rad
};
/// C_en: its columns are north, east, down in ECEF.
Direction direction_in(const Eigen::Matrix3d& C_en, const Eigen::Vector3d& direction);

}  // namespace binnacle::gnss
