// SPDX-License-Identifier: Apache-2.0
#include "calendar_time.hpp"

#include <cmath>

#include "cells.hpp"

namespace binnacle::csv {

namespace {

std::string flaw(const std::string& column, std::string_view cell, const std::string& what) {
  const std::string where = "time column '" + column + "'";
  return cell.empty() ? where + " is empty" : where + ": '" + std::string(cell.substr(0, 40)) + "' is " + what;
}

std::string read_gps(const CalendarTime& time, std::string_view cell, const std::string& name,
                     std::string_view week_cell, std::int64_t unit, Time& label) {
  double week = 0;
  if (parse_number(week_cell, week) != CellFault::none || !(week >= 0 && week <= 9999) || week != std::floor(week))
    return flaw(time.other_name, week_cell, "no GPS week");
  Time seconds = 0;
  if (parse_time(cell, unit, seconds) != CellFault::none) return flaw(name, cell, "not a number");
  if (seconds < 0 || seconds > civil_time::week_length)
    return flaw(name, cell, "not a time of a week, which has 604800 s");
  label = time.clock.time_of_gps(static_cast<Time>(week) * civil_time::week_length + seconds);
  return {};
}

}  // namespace

std::string CalendarTime::read(std::string_view cell, const std::string& name, std::string_view other_cell,
                               std::int64_t unit, Time& label) const {
  using namespace civil_time;
  if (form == Form::week_and_seconds) return read_gps(*this, cell, name, other_cell, unit, label);
  std::optional<Utc> utc;
  if (form == Form::instant) {
    utc = parse_utc(cell, zone);
    if (!utc) return flaw(name, cell, "not a time of ISO 8601, as 2026-11-23T12:00:05.25Z is");
  } else {
    static constexpr const char* orders[] = {"year, month, day", "day, month, year", "month, day, year"};
    const auto day = parse_date(other_cell, order);
    if (!day)
      return flaw(other_name, other_cell, std::string("not a date of ") + orders[static_cast<std::size_t>(order)]);
    const auto time = parse_clock(cell);
    if (!time) return flaw(name, cell, "not a time of day, as 12:00:05.25 is");
    utc = utc_of(*day, *time, zone);
    if (!utc) return flaw(name, cell, "a leap second at the wrong time");
  }
  label = clock.time(*utc);
  return {};
}

}  // namespace binnacle::csv
