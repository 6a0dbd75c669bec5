// SPDX-License-Identifier: Apache-2.0
#include "civil_time/utc_clock.hpp"

#include <array>

#include "civil_time/iso8601.hpp"

namespace binnacle::civil_time {

namespace {

using namespace std::chrono;

struct LeapSecond {
  year_month_day from;
  int gps_minus_utc;  // [s]
};

/// The day from which GPS − UTC is so many seconds.
constexpr std::array<LeapSecond, 18> leap_second_table{{{1981y / 7 / 1, 1},
                                                        {1982y / 7 / 1, 2},
                                                        {1983y / 7 / 1, 3},
                                                        {1985y / 7 / 1, 4},
                                                        {1988y / 1 / 1, 5},
                                                        {1990y / 1 / 1, 6},
                                                        {1991y / 1 / 1, 7},
                                                        {1992y / 7 / 1, 8},
                                                        {1993y / 7 / 1, 9},
                                                        {1994y / 7 / 1, 10},
                                                        {1996y / 1 / 1, 11},
                                                        {1997y / 7 / 1, 12},
                                                        {1999y / 1 / 1, 13},
                                                        {2006y / 1 / 1, 14},
                                                        {2009y / 1 / 1, 15},
                                                        {2012y / 7 / 1, 16},
                                                        {2015y / 7 / 1, 17},
                                                        {2017y / 1 / 1, 18}}};

constexpr Time second = nanoseconds_per_second;

Day day_of(Time since_1970) {
  return floor<days>(sys_time<std::chrono::nanoseconds>(std::chrono::nanoseconds(since_1970)));
}

}  // namespace

std::optional<Day> parse_day(std::string_view text) {
  if (text.size() != 10 || text[4] != '-') return {};
  return parse_date(text);
}

std::optional<Time> parse_instant(std::string_view text) {
  if (text.ends_with('Z') && text.size() == 11) text.remove_suffix(1);
  if (const auto day = parse_day(text)) return begin_of(*day);
  const auto utc = parse_utc(text);
  if (!utc) return {};
  return begin_of(utc->day) + utc->of_day;
}

std::vector<ParameterSpec> UtcClock::parameters() {
  using namespace parameter;
  std::vector<ParameterSpec> specs;
  specs.push_back(integer("week").at_least(0).at_most(9999).about(
      "GPS week at whose start the time of the channels is zero, in GPS time; 0: 1980-01-06"));
  specs.push_back(
      text("epoch").about("instant at which the time of the channels is zero, in seconds of UTC without leap seconds, "
                          "for example \"2026-11-23T12:00:00Z\"; Unix time: \"1970-01-01T00:00:00Z\""));
  specs.push_back(integer("leap_seconds")
                      .at_least(0)
                      .at_most(100)
                      .about("GPS time minus UTC, with 'week'; default: by date, 18 s since 2017-01-01"));
  return specs;
}

UtcClock::UtcClock(const Parameters& parameters) {
  origin_ = begin_of(gps_epoch);
  if (parameters.has("week")) origin_ += parameters.integer("week") * 7 * day_length;
  if (parameters.has("leap_seconds")) leap_seconds_ = parameters.integer("leap_seconds") * second;
  if (!parameters.has("epoch")) return;
  if (parameters.has("week")) throw ComponentError("'week' is given too, and both give the origin of time", "/epoch");
  if (leap_seconds_) throw ComponentError("'epoch' is UTC, which needs none; they belong to 'week'", "/leap_seconds");
  const auto instant = parse_instant(parameters.text("epoch"));
  if (!instant)
    throw ComponentError("'" + parameters.text("epoch") +
                             "' is not an instant of UTC; expected \"2026-11-23T12:00:00Z\"",
                         "/epoch");
  origin_ = *instant;
  is_gps_ = false;
}

UtcClock UtcClock::from_week(std::int64_t week, std::optional<std::int64_t> leap_seconds) {
  UtcClock clock;
  clock.origin_ = begin_of(gps_epoch) + week * week_length;
  if (leap_seconds) clock.leap_seconds_ = *leap_seconds * second;
  return clock;
}

UtcClock UtcClock::from_epoch(Time since_1970) {
  UtcClock clock;
  clock.origin_ = since_1970;
  clock.is_gps_ = false;
  return clock;
}

Time UtcClock::leap_seconds(Day day) const {
  if (leap_seconds_) return *leap_seconds_;
  int found = 0;
  for (const LeapSecond& leap : leap_second_table)
    if (day >= Day(leap.from)) found = leap.gps_minus_utc;
  return found * second;
}

Utc UtcClock::utc(Time t) const {
  const Time since_1970 = origin_ + t;
  const auto split = [](Time utc) {
    const Day day = day_of(utc);
    return Utc{day, utc - begin_of(day)};
  };
  if (!is_gps_) return split(since_1970);
  if (leap_seconds_) return split(since_1970 - *leap_seconds_);
  Time offset = 0;
  for (const LeapSecond& leap : leap_second_table) {
    const Time inserted = begin_of(Day(leap.from)) + offset;
    if (since_1970 < inserted) break;
    if (since_1970 < inserted + second) return {Day(leap.from) - days(1), day_length + since_1970 - inserted};
    offset = leap.gps_minus_utc * second;
  }
  return split(since_1970 - offset);
}

Time UtcClock::time_of_gps(Time gps, std::optional<Time> data_leap) const {
  const Time since_1970 = gps + begin_of(gps_epoch);
  if (is_gps_) return since_1970 - origin_;
  if (data_leap) return since_1970 - *data_leap - origin_;
  // As in the table: of an inserted second the same number as of the one after it.
  Time offset = 0;
  for (const LeapSecond& leap : leap_second_table) {
    if (since_1970 < begin_of(Day(leap.from)) + leap.gps_minus_utc * second) break;
    offset = leap.gps_minus_utc * second;
  }
  return since_1970 - offset - origin_;
}

Time UtcClock::time(const Utc& utc) const {
  const Time since_1970 = begin_of(utc.day) + utc.of_day;
  return since_1970 - origin_ + (is_gps_ ? leap_seconds(utc.day) : 0);
}

}  // namespace binnacle::civil_time
