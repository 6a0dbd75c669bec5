// SPDX-License-Identifier: Apache-2.0
#include "text.hpp"

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace binnacle::convert {

void append_fixed(std::string& text, double value, int decimals) {
  std::array<char, 400> all;
  const auto end = std::to_chars(all.data(), all.data() + all.size(), value, std::chars_format::fixed, decimals);
  text.append(all.data(), end.ptr);
}

void append_exact(std::string& text, double value) {
  if (std::isnan(value)) {
    text += "nan";
    return;
  }
  std::array<char, 32> all;
  const auto end = std::to_chars(all.data(), all.data() + all.size(), value + 0.0);  // no "-0"
  text.append(all.data(), end.ptr);
}

int decimals_of(const std::vector<Record>& records) {
  constexpr Time millisecond = 1'000'000,
                 near = 500;  // a double of seconds since 1980 is known to a quarter of a microsecond
  for (const Record& record : records) {
    const Time off = ((record.t % millisecond) + millisecond) % millisecond;
    if (off > near && off < millisecond - near) return 6;
  }
  return 3;
}

std::string calendar(Time since_1970, int decimals, char of_date, char between) {
  const Time unit = decimals == 3 ? 1'000'000 : 1'000;
  const Time half = unit / 2, up = since_1970 + half;
  const Time rounded = up - ((up % unit) + unit) % unit;
  const auto day = std::chrono::floor<std::chrono::days>(
      std::chrono::sys_time<std::chrono::nanoseconds>(std::chrono::nanoseconds(rounded)));
  const std::chrono::year_month_day date(day);
  const Time of_day = rounded - civil_time::begin_of(day);
  const auto s = of_day / nanoseconds_per_second;
  std::array<char, 64> all;
  std::snprintf(all.data(), all.size(), "%04d%c%02u%c%02u%c%02d:%02d:%02d.%0*lld", static_cast<int>(date.year()),
                of_date, static_cast<unsigned>(date.month()), of_date, static_cast<unsigned>(date.day()), between,
                static_cast<int>(s / 3600), static_cast<int>(s / 60 % 60), static_cast<int>(s % 60), decimals,
                static_cast<long long>(of_day % nanoseconds_per_second / unit));
  return all.data();
}

std::string iso(const civil_time::Utc& utc, int decimals) {
  return calendar(civil_time::begin_of(utc.day) + utc.of_day, decimals, '-', 'T') + "Z";
}

}  // namespace binnacle::convert
