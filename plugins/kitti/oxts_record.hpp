// SPDX-License-Identifier: Apache-2.0
// A line of OXTS data and its stamp, as KITTI's raw recordings have them.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "civil_time/utc_clock.hpp"

namespace binnacle::kitti {

/// North, east, down and forward, right, down, where the file has east, north, up and forward, left, up.
struct OxtsRecord {
  Eigen::Vector3d lla;              // rad, rad, m
  Eigen::Vector3d v_n;              // m/s
  Eigen::Vector3d attitude;         // roll, pitch, yaw [rad]
  Eigen::Vector3d w_b;              // rad/s
  Eigen::Vector3d f_b;              // m/s²
  double position_sd, velocity_sd;  // m, m/s
  std::array<double, 5> state;      // navigation status, satellites, modes of position, velocity, orientation
};

/// Why it is no record; empty: it is one.
std::string read_record(std::string_view line, OxtsRecord& record);

/// "2011-09-26 13:02:25.964389445"; nothing if it is none.
std::optional<civil_time::Utc> read_stamp(std::string_view line);

}  // namespace binnacle::kitti
