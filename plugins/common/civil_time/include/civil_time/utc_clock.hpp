// SPDX-License-Identifier: Apache-2.0
// UTC, which sentences carry, and the time of channels.
#pragma once

#include <chrono>
#include <optional>
#include <string_view>
#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"

namespace binnacle::civil_time {

using Day = std::chrono::sys_days;

/// "2026-11-23"; empty where it is no day of the calendar, or none from 1900 to 2200.
std::optional<Day> parse_day(std::string_view text);
/// "2026-11-23T12:00:00Z", also without seconds, time or Z: nanoseconds of UTC since 1970.
std::optional<Time> parse_instant(std::string_view text);

/// Days and weeks of GPS time begin here.
inline constexpr Day gps_epoch = std::chrono::year(1980) / 1 / 6;
inline constexpr Time day_length = 86400 * nanoseconds_per_second;
inline constexpr Time week_length = 7 * day_length;

/// From 1970-01-01 to the begin of a day [ns].
constexpr Time begin_of(Day day) noexcept { return Time{day.time_since_epoch().count()} * day_length; }

/// An instant of UTC. In a leap second the time of day is 86400 s and more.
struct Utc {
  Day day;
  Time of_day = 0;  // [ns]
};

/// Channels count either GPS time from the begin of a week (`week`), whose leap seconds are a table (IERS Bulletin C; the
/// last one of 2016-12-31) or given (`leap_seconds`), or seconds of UTC from an instant (`epoch`), as Unix time does, in which
/// there are no leap seconds.
class UtcClock {
 public:
  static std::vector<ParameterSpec> parameters();
  /// Throws ComponentError where both are given, or one is wrong. Neither: GPS time from 1980-01-06.
  explicit UtcClock(const Parameters& parameters);

  Utc utc(Time t) const;
  Time time(const Utc& utc) const;
  /// Of an instant of GPS time, ns since 1980-01-06. `data_leap`: GPS − UTC [ns] as the data give it; `leap_seconds` of
  /// the config counts before it, the table after it.
  Time time_of_gps(Time gps, std::optional<Time> data_leap = {}) const;
  /// GPS time since 1980-01-06 of an instant of UTC.
  Time gps_of(const Utc& utc) const {
    return begin_of(utc.day) + utc.of_day + leap_seconds(utc.day) - begin_of(gps_epoch);
  }

 private:
  Time leap_seconds(Day day) const;

  Time origin_ = 0;  // of UTC since 1970, or of GPS time since 1970 as if it had no leap seconds [ns]
  bool is_gps_ = true;
  std::optional<Time> leap_seconds_;  // GPS − UTC [ns]
};

}  // namespace binnacle::civil_time
