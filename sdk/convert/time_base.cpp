// SPDX-License-Identifier: Apache-2.0
#include "convert/time_base.hpp"

#include "convert/track.hpp"

namespace binnacle::convert {

namespace {

using civil_time::UtcClock;
using results::Json;

std::string week_text(std::int64_t week, std::optional<std::int64_t> leap_seconds) {
  return (week == 0 ? std::string("GPS time since 1980-01-06")
                    : "GPS time from the start of week " + std::to_string(week)) +
         ", GPS - UTC " + (leap_seconds ? std::to_string(*leap_seconds) + " s" : std::string("by date"));
}

TimeBase of_week(std::int64_t week, std::optional<std::int64_t> leap_seconds, const std::string& from) {
  return {UtcClock::from_week(week, leap_seconds), week_text(week, leap_seconds), from};
}

TimeBase of_epoch(const std::string& epoch, const std::string& from) {
  const auto instant = civil_time::parse_instant(epoch);
  if (!instant) throw Refusal("'" + epoch + "' is not an instant of UTC (" + from + "); expected 2026-11-23T12:00:00Z");
  return {UtcClock::from_epoch(*instant), "UTC from " + epoch, from};
}

std::optional<TimeBase> stated(const Json& component, const std::string& place,
                               const std::optional<std::int64_t>& leap_seconds) {
  const auto integer = [&](const char* key) -> std::optional<std::int64_t> {
    const auto found = component.find(key);
    return found != component.end() && found->is_number_integer() ? std::optional(found->get<std::int64_t>())
                                                                  : std::nullopt;
  };
  if (const auto week = integer("week"))
    return of_week(*week, leap_seconds ? leap_seconds : integer("leap_seconds"), place + "/week of the run's config");
  const auto epoch = component.find("epoch");
  if (epoch != component.end() && epoch->is_string() && civil_time::parse_instant(epoch->get<std::string>()))
    return of_epoch(epoch->get<std::string>(), place + "/epoch of the run's config");
  return {};
}

/// The same instant of UTC, wherever the clock stands.
bool agree(const TimeBase& a, const TimeBase& b, Time t) {
  const auto x = a.clock.utc(t), y = b.clock.utc(t);
  return x.day == y.day && x.of_day == y.of_day;
}

}  // namespace

std::optional<TimeBase> time_base(const Json& config, const GivenTime& given, Time at) {
  if (given.week && !given.epoch.empty())
    throw Refusal("--week and --epoch both give the origin of time; give one of them");
  if (!given.epoch.empty() && given.leap_seconds)
    throw Refusal("--leap-seconds belongs to GPS time, --week; --epoch is UTC, which needs none");
  if (given.week) return of_week(*given.week, given.leap_seconds, "--week");
  if (!given.epoch.empty()) return of_epoch(given.epoch, "--epoch");
  std::optional<TimeBase> found;
  for (const char* section : {"sources", "sinks"}) {
    const auto components = config.find(section);
    if (components == config.end() || !components->is_object()) continue;
    for (const auto& [name, component] : components->items()) {
      if (!component.is_object()) continue;
      const auto base = stated(component, std::string("/") + section + "/" + name, given.leap_seconds);
      if (base && found && !agree(*base, *found, at))
        throw Refusal("the run's config gives two different origins of time: " + found->text + " (" + found->from +
                      "), " + base->text + " (" + base->from + "); --week or --epoch decides");
      if (base && !found) found = base;
    }
  }
  if (!found && given.leap_seconds) throw Refusal("--leap-seconds belongs to GPS time; --week selects it");
  return found;
}

}  // namespace binnacle::convert
