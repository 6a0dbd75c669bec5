// SPDX-License-Identifier: Apache-2.0
// Track: where a filter was, however its state says it.
#pragma once

#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "binnacle/time.hpp"
#include "results/results.hpp"

namespace binnacle::convert {

/// What is asked for cannot be had of these results; one line that says what is missing and what to do.
class Refusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The results have nothing of the kind, whatever is asked for.
class NoData : public Refusal {
 public:
  using Refusal::Refusal;
};

/// A place on WGS 84: latitude and longitude [rad], height above the ellipsoid [m].
struct Place {
  double lat = 0, lon = 0, height = 0;
  std::string from;  // who says so: "/origin of the config"
};

/// In which axes a position is estimated.
enum class PositionKind { geodetic, ecef, local };

/// One record. What is not estimated is NaN.
struct Record {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  Time t = 0;
  std::size_t index = 0;                                   // in FilterResults
  double lat = unknown, lon = unknown, height = unknown;   // WGS 84 [rad, m]
  double ecef[3] = {unknown, unknown, unknown};            // [m]
  double sigma[3] = {unknown, unknown, unknown};           // north, east, down; of an ECEF state x, y, z [m]
  double velocity[3] = {unknown, unknown, unknown};        // north, east, down [m/s]
  double velocity_sigma[3] = {unknown, unknown, unknown};  // the same; of an ECEF state along x, y, z
  double yaw = unknown;                                    // from true north to east [rad]

  double horizontal_sigma() const;
};

struct Track {
  std::string filter, block;
  PositionKind kind = PositionKind::geodetic;
  bool has_velocity = false, is_velocity_ecef = false, has_yaw = false, has_vertical = true;
  std::vector<Record> records;
  std::size_t left_out = 0;  // records of which the position is not finite
};

/// Of the first block with a position: kind `position` or `position.ecef`, else outputs north and east (with down or
/// height) in metres about `origin`. Records before `indices` are chosen as it says. Throws Refusal where there is no such
/// block, or no origin for it.
Track track_of(const results::FilterResults& filter, const std::vector<std::size_t>& indices,
               const std::optional<Place>& origin);

/// Times of a filter in whole nanoseconds.
std::vector<Time> times_of(const results::FilterResults& filter);

/// Every `every`-th record; of these the first at or after each multiple of 1/rate from the first one (rate 0: all).
std::vector<std::size_t> chosen(const std::vector<Time>& t, std::size_t every, double rate);

}  // namespace binnacle::convert
