// SPDX-License-Identifier: Apache-2.0
// A line of a solution file: position, velocity and their covariances, whatever the form of the coordinates.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "civil_time/utc_clock.hpp"
#include "layout.hpp"

namespace binnacle::rtklib {

struct Solution {
  static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  Time t = no_time;                                                      // of channels
  Eigen::Vector3d lla = Eigen::Vector3d::Constant(nan);                  // rad, rad, m above the ellipsoid
  Eigen::Vector3d relative = Eigen::Vector3d::Constant(nan);             // baseline, north, east, down [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Constant(nan);             // north, east, down [m/s]
  Eigen::Matrix3d position_covariance = Eigen::Matrix3d::Constant(nan);  // north, east, down [m²]
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Constant(nan);
  double quality = nan, satellites = nan, age = nan, ratio = nan;
};

struct Place {
  double geoid_separation = Solution::nan;   // for heights above the sea
  std::optional<Eigen::Vector3d> reference;  // of baselines: lat, lon [rad], height [m]
};

/// Thrown: why a line is no solution.
struct BadLine {
  std::string why;
};

/// Throws BadLine.
Solution read_solution(std::string_view line, const Layout& layout, const Place& place,
                       const civil_time::UtcClock& clock);

}  // namespace binnacle::rtklib
