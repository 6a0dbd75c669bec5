// SPDX-License-Identifier: Apache-2.0
// GPS time: weeks and seconds since 1980-01-06, and the calendar.
#pragma once

#include <cmath>
#include <cstdint>

#include "binnacle/time.hpp"

namespace binnacle::gnss {

inline constexpr std::int64_t seconds_per_week = 604800;
inline constexpr double seconds_per_day = 86400.0;
/// BeiDou's time is that of GPS less 14 s, and its week 0 is GPS week 1356 (BDS-SIS-ICD-B1I-3.0, 3.3).
inline constexpr double gps_minus_beidou = 14.0;
inline constexpr int beidou_week_zero = 1356;

/// Days from 1980-01-06 to a date of the Gregorian calendar (Fliegel and Van Flandern, CACM 11 (1968) 657).
constexpr std::int64_t gps_day(int year, int month, int day) noexcept {
  const std::int64_t y = year, m = month, d = day;
  const std::int64_t julian = d - 32075 + 1461 * (y + 4800 + (m - 14) / 12) / 4 +
                              367 * (m - 2 - (m - 14) / 12 * 12) / 12 - 3 * ((y + 4900 + (m - 14) / 12) / 100) / 4;
  return julian - 2444245;
}

/// Channels that carry GNSS data count time from the begin of some GPS week, 0:00 of a Sunday. So the time of week and
/// of day follow from a channel's time alone.
inline double time_of_week(double channel_seconds) noexcept {
  const double t = std::fmod(channel_seconds, static_cast<double>(seconds_per_week));
  return t < 0 ? t + static_cast<double>(seconds_per_week) : t;
}
inline double time_of_day(Time t) noexcept {
  constexpr Time day = 86400 * nanoseconds_per_second;
  const Time rest = t % day;
  return seconds(rest < 0 ? rest + day : rest);
}

}  // namespace binnacle::gnss
