// SPDX-License-Identifier: Apache-2.0
// Fields by which a place and a motion are played.
#pragma once

#include "binnacle/eigen.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

inline FieldSpec level(const char* name, const char* unit, const char* text) {
  return field::level(name, unit).about(text);
}

struct PlaceFields {
  OutputFields<3> position, velocity;
};

inline PlaceFields carry_ecef(ChannelDeclaration& channel) {
  const char *const place = "ECEF position", *const motion = "ECEF velocity";
  const auto position = channel.carries(level("x", "m", place), level("y", "m", place), level("z", "m", place));
  return {position,
          channel.carries(level("vx", "m/s", motion), level("vy", "m/s", motion), level("vz", "m/s", motion))};
}

inline PlaceFields carry_geodetic(ChannelDeclaration& channel) {
  const auto position =
      channel.carries(level("lat", "rad", "geodetic latitude"), level("lon", "rad", "longitude, east positive"),
                      level("height", "m", "height above the ellipsoid"));
  return {position, channel.carries(level("vn", "m/s", "velocity over ground, north"),
                                    level("ve", "m/s", "velocity over ground, east"),
                                    level("vd", "m/s", "velocity over ground, down"))};
}

}  // namespace binnacle::gnss_range
