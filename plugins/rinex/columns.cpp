// SPDX-License-Identifier: Apache-2.0
// Numbers and times in fixed columns, as FORTRAN writes them.
#include "columns.hpp"

#include <charconv>
#include <cmath>

#include "gnss/gps_time.hpp"

namespace binnacle::rinex {

std::string_view columns(std::string_view line, std::size_t first, std::size_t width) {
  return first < line.size() ? line.substr(first, width) : std::string_view();
}

std::optional<double> number(std::string_view text) {
  text = trimmed(text);
  constexpr std::size_t longest = 32;
  char cell[longest];
  if (text.empty() || text.size() > longest) return std::nullopt;
  std::size_t size = 0;
  for (const char c : text) cell[size++] = c == 'D' || c == 'd' ? 'e' : c;
  const char* begin = cell;
  if (*begin == '+') ++begin;
  double value = 0;
  const auto [rest, error] = std::from_chars(begin, cell + size, value);
  if (error != std::errc() || rest != cell + size || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<int> integer(std::string_view text) {
  text = trimmed(text);
  int value = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || text.empty() || rest != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<Time> gps_time(std::string_view year, std::string_view month, std::string_view day, std::string_view hour,
                             std::string_view minute, std::string_view second, int origin_week) {
  const auto y = integer(year), mo = integer(month), d = integer(day), h = integer(hour), mi = integer(minute);
  const auto s = number(second);
  if (!y || !mo || !d || !h || !mi || !s) return std::nullopt;
  const int full_year = *y < 80 ? *y + 2000 : *y < 100 ? *y + 1900 : *y;
  const auto within = [](auto value, auto least, auto most) { return value >= least && value <= most; };
  if (!within(full_year, 1980, 2099) || !within(*mo, 1, 12) || !within(*d, 1, 31) || !within(*h, 0, 23) ||
      !within(*mi, 0, 59) || !within(*s, 0.0, 60.999))
    return std::nullopt;
  const std::int64_t day_number = gnss::gps_day(full_year, *mo, *d) - 7 * std::int64_t{origin_week};
  return ((day_number * 24 + *h) * 60 + *mi) * 60 * nanoseconds_per_second + nanoseconds(*s);
}

}  // namespace binnacle::rinex
