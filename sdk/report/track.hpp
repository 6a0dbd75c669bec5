// SPDX-License-Identifier: Apache-2.0
// The track on the ground, in metres east and north of where it began.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "results/results.hpp"

namespace binnacle::report {

struct Path {
  std::vector<double> t, east, north;
};

struct Track {
  std::string block;
  double lat = 0, lon = 0;  // of the origin [rad]; NaN where the state is not geographic
  Path estimate;
  std::vector<double> sigma;  // horizontal, 1-σ, as long as the estimate [m]
  Path reference;             // estimate ⊞ error, where both are known
  std::vector<double> error;  // horizontal, as long as the reference [m]
};

/// Latitude and longitude [rad].
struct TrackOrigin {
  double lat, lon;
};

/// Of the first block with outputs lat and lon, or north and east in metres. A geographic one is about `origin`, or about
/// where it begins.
std::optional<Track> track_of(const results::FilterResults& filter, const std::optional<TrackOrigin>& origin = {});

}  // namespace binnacle::report
