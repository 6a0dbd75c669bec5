// SPDX-License-Identifier: Apache-2.0
// Fields by which a place and a motion are told.
#pragma once

#include <vector>

#include "binnacle/spec.hpp"

namespace binnacle::gnss_range {

inline FieldSpec level(const char* name, const char* unit, const char* text) {
  return {name, unit, FieldKind::level, false, false, text};
}

inline std::vector<FieldSpec> ecef_fields() {
  return {level("x", "m", "ECEF position"),    level("y", "m", "ECEF position"),
          level("z", "m", "ECEF position"),    level("vx", "m/s", "ECEF velocity"),
          level("vy", "m/s", "ECEF velocity"), level("vz", "m/s", "ECEF velocity")};
}

inline std::vector<FieldSpec> geodetic_fields() {
  return {level("lat", "rad", "geodetic latitude"),         level("lon", "rad", "longitude, east positive"),
          level("height", "m", "above the ellipsoid"),      level("vn", "m/s", "velocity over ground, north"),
          level("ve", "m/s", "velocity over ground, east"), level("vd", "m/s", "velocity over ground, down")};
}

/// Position and velocity, first in ECEF axes and then geodetic.
inline std::vector<FieldSpec> place_fields() {
  auto fields = ecef_fields();
  for (auto& field : geodetic_fields()) fields.push_back(std::move(field));
  return fields;
}

}  // namespace binnacle::gnss_range
