// SPDX-License-Identifier: Apache-2.0
// Radii and gravity from sin L, cos L and 1/√(1 − e² sin²L): the part of the earth that a step shares.
#pragma once

#include <cmath>

#include "strapdown/earth.hpp"

namespace binnacle::strapdown::detail {

/// 1/√(1 − e² sin²L)
inline double inverse_w(double sin_lat) { return 1.0 / std::sqrt(1.0 - wgs84::e2 * sin_lat * sin_lat); }

inline Radii radii(double sin_lat, double cos_lat, double inverse_w) {
  using namespace wgs84;
  const double inverse_w2 = inverse_w * inverse_w;
  const double transverse = a * inverse_w;
  const double meridian = (1.0 - e2) * transverse * inverse_w2;
  const double slope = e2 * sin_lat * cos_lat * inverse_w2;
  return {meridian, transverse, 3.0 * meridian * slope, transverse * slope};
}

inline Gravity gravity(double sin_lat, double cos_lat, double inverse_w, double height) {
  using namespace wgs84;
  const double s2 = sin_lat * sin_lat, sc = sin_lat * cos_lat;
  const double somigliana = 1.0 + k * s2;
  const double surface = gamma_e * somigliana * inverse_w;
  const double surface_lat = gamma_e * inverse_w * sc * (2.0 * k + somigliana * e2 * inverse_w * inverse_w);
  const double slope = (2.0 / a) * (1.0 + f + m - 2.0 * f * s2);
  const double slope_lat = -(8.0 / a) * f * sc;
  const double factor = 1.0 + height * (-slope + (3.0 / (a * a)) * height);
  return {surface * factor, surface_lat * factor - surface * slope_lat * height,
          surface * (-slope + (6.0 / (a * a)) * height)};
}

}  // namespace binnacle::strapdown::detail
