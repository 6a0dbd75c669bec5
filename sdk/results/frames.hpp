// SPDX-License-Identifier: Apache-2.0
// Frames and CF's names of what blocks of the known kinds read.
#pragma once

#include <string>
#include <vector>

namespace binnacle::results {

/// "" of a kind without a frame of its own.
inline std::string frame_of(const std::string& kind) {
  if (kind == "position") return "WGS 84: geodetic latitude and longitude, height above the ellipsoid";
  if (kind == "velocity.ned") return "north, east, down";
  if (kind == "attitude") return "body to north-east-down, by turns about z, y, x";
  if (kind.ends_with(".ecef")) return "Earth-centred, Earth-fixed";
  return {};
}

inline std::string error_frame_of(const std::vector<std::string>& components) {
  return components == std::vector<std::string>{"north", "east", "down"} ? "north, east, down" : "";
}

inline std::string standard_name_of(const std::string& kind, const std::string& output) {
  if (kind != "position") return {};
  if (output == "lat") return "latitude";
  if (output == "lon") return "longitude";
  return output == "height" ? "height_above_reference_ellipsoid" : "";
}

}  // namespace binnacle::results
