// SPDX-License-Identifier: Apache-2.0
// Columns in local axes: positions in metres from an origin become latitude, longitude and height.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "binnacle/local_axes.hpp"

namespace binnacle::csv {

/// Of the values of a line, three or six from `first` on: north, east, down (or up) from the origin [m], then, where there are
/// velocities, along the same axes [m/s]. They become lat, lon [rad], height [m], and velocity north, east, down of that place.
struct LocalColumns {
  geodesy::LocalAxes axes;
  std::size_t first = 0;
  bool has_velocity = false;
  double down_sign = 1, velocity_down_sign = 1;  // -1: the column is up

  /// Three where one is missing are all missing (NaN). False: not a place on or near the earth.
  bool turn(std::vector<double>& row) const {
    constexpr double farthest = 1e7;
    Eigen::Map<Eigen::Vector3d> position(row.data() + first);
    position[2] *= down_sign;
    for (const double metres : position)
      if (std::abs(metres) > farthest) return false;
    const Eigen::Vector3d lla = axes.lla_from_ned(position);
    position = lla;
    if (!has_velocity) return true;
    Eigen::Map<Eigen::Vector3d> velocity(row.data() + first + 3);
    velocity[2] *= velocity_down_sign;
    velocity = (axes.C_nl(lla) * velocity).eval();
    return true;
  }
};

}  // namespace binnacle::csv
