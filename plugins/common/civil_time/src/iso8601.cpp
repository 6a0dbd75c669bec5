// SPDX-License-Identifier: Apache-2.0
#include "civil_time/iso8601.hpp"

#include <array>

namespace binnacle::civil_time {

namespace {

using namespace std::chrono;

constexpr Time second_length = nanoseconds_per_second, minute_length = 60 * second_length;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Takes from `least` to `most` digits from the front; −1 where there are not as many.
int take_number(std::string_view& text, std::size_t least, std::size_t most) {
  int value = 0;
  std::size_t count = 0;
  for (; count < most && count < text.size() && is_digit(text[count]); ++count)
    value = value * 10 + (text[count] - '0');
  if (count < least) return -1;
  text.remove_prefix(count);
  return value;
}

bool take(std::string_view& text, char c) {
  const bool is_there = !text.empty() && text[0] == c;
  if (is_there) text.remove_prefix(1);
  return is_there;
}

/// Digits behind the point of seconds, in nanoseconds, rounded half up; −1 where there is none or something else.
Time take_fraction(std::string_view& text) {
  Time value = 0, place = second_length;
  bool rounds_up = false;
  std::size_t count = 0;
  for (; count < text.size() && is_digit(text[count]); ++count) {
    if (count < 9)
      value += (text[count] - '0') * (place /= 10);
    else if (count == 9)
      rounds_up = text[count] >= '5';
  }
  if (count == 0) return -1;
  text.remove_prefix(count);
  return value + (rounds_up ? 1 : 0);
}

/// What is behind the time of day; false where it is no zone.
bool read_zone(std::string_view text, std::optional<Time>& zone) {
  if (text.empty()) return true;
  if (text == "Z" || text == "z") {
    zone = 0;
    return true;
  }
  const bool is_west = text[0] == '-';
  if (!is_west && text[0] != '+') return false;
  text.remove_prefix(1);
  const int hours = take_number(text, 2, 2);
  const bool has_colon = take(text, ':');
  const int minutes = text.empty() && !has_colon ? 0 : take_number(text, 2, 2);
  if (hours < 0 || hours > 23 || minutes < 0 || minutes > 59 || !text.empty()) return false;
  zone = (is_west ? -1 : 1) * (hours * 60 + minutes) * minute_length;
  return true;
}

}  // namespace

std::optional<Day> parse_date(std::string_view text, DateOrder order) {
  // Which of year, month, day comes first, second, third.
  constexpr std::array<std::array<int, 3>, 3> orders{{{0, 1, 2}, {2, 1, 0}, {1, 2, 0}}};
  std::array<int, 3> parts{};  // year, month, day
  const std::size_t separator_at = text.find_first_of("-/.");
  const char separator = separator_at == text.npos ? '\0' : text[separator_at];
  for (std::size_t i = 0; i < 3; ++i) {
    const int part = orders[static_cast<std::size_t>(order)][i];
    if (i > 0 && separator != '\0' && !take(text, separator)) return {};
    const std::size_t least = part == 0 ? 4 : separator == '\0' ? 2 : 1;
    const int value = take_number(text, least, part == 0 ? 4 : 2);
    if (value < 0) return {};
    parts[static_cast<std::size_t>(part)] = value;
  }
  if (!text.empty() || parts[0] < 1900 || parts[0] > 2200) return {};  // nanoseconds of others are too many
  const year_month_day date{year(parts[0]), month(static_cast<unsigned>(parts[1])),
                            day(static_cast<unsigned>(parts[2]))};
  if (!date.ok()) return {};
  return Day(date);
}

std::optional<ClockTime> parse_clock(std::string_view text) {
  ClockTime time;
  const int hours = take_number(text, 2, 2);
  const bool has_colons = take(text, ':');
  const int minutes = take_number(text, 2, 2);
  if (hours < 0 || hours > 23 || minutes < 0 || minutes > 59) return {};
  time.minute = (hours * 60 + minutes) * minute_length;
  const bool has_seconds = has_colons ? take(text, ':') : !text.empty() && is_digit(text[0]);
  if (has_seconds) {
    const int seconds = take_number(text, 2, 2);
    if (seconds < 0 || seconds > 60) return {};
    time.second = seconds * second_length;
    time.is_leap = seconds == 60;
    if (take(text, '.') || take(text, ',')) {
      const Time fraction = take_fraction(text);
      if (fraction < 0) return {};
      time.second += fraction;
    }
  }
  if (!read_zone(text, time.zone)) return {};
  return time;
}

std::optional<Utc> utc_of(Day day, const ClockTime& time, Time zone) {
  Time minute = time.minute - time.zone.value_or(zone);
  for (; minute < 0; minute += day_length) day -= days(1);
  for (; minute >= day_length; minute -= day_length) day += days(1);
  if (time.is_leap && minute != day_length - minute_length) return {};
  return Utc{day, minute + time.second};
}

std::optional<Utc> parse_utc(std::string_view text, Time zone) {
  const std::size_t end = text.find_first_of("T t");
  if (end == text.npos) return {};
  const auto day = parse_date(text.substr(0, end));
  const auto time = parse_clock(text.substr(end + 1));
  if (!day || !time) return {};
  return utc_of(*day, *time, zone);
}

}  // namespace binnacle::civil_time
