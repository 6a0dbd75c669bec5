// SPDX-License-Identifier: Apache-2.0
// Dates and times of day as people and loggers write them: ISO 8601 and its relatives.
#pragma once

#include <optional>
#include <string_view>

#include "civil_time/utc_clock.hpp"

namespace binnacle::civil_time {

enum class DateOrder { ymd, dmy, mdy };

/// A day of the calendar from 1900 to 2200; year of four digits, month and day of two (one, where there are separators).
/// Separators are all "-", "/" or ".", or there are none: "2026-11-23", "20261123"; dmy: "23.11.2026"; mdy: "11/23/2026".
std::optional<Day> parse_date(std::string_view text, DateOrder order = DateOrder::ymd);

/// A time of day, and the zone where one is written behind it.
struct ClockTime {
  Time minute = 0;           // from midnight to the full minute [ns]
  Time second = 0;           // from there on [ns]
  bool is_leap = false;      // the 61st second of its minute
  std::optional<Time> zone;  // minus UTC [ns]
};

/// "12:00", "12:00:05", "120005", with a fraction behind a point or comma, rounded to the nanosecond; behind it "Z", "+01:00",
/// "+0100" or "+01".
std::optional<ClockTime> parse_clock(std::string_view text);

/// `zone`: minus UTC, where the time has none of its own. Nothing where a leap second is not the last of a day.
std::optional<Utc> utc_of(Day day, const ClockTime& time, Time zone = 0);

/// A date, "T" or a blank, and a time of day: "2026-11-23T12:00:05.25+01:00".
std::optional<Utc> parse_utc(std::string_view text, Time zone = 0);

}  // namespace binnacle::civil_time
