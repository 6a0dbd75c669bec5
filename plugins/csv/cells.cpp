// SPDX-License-Identifier: Apache-2.0
// From a line to its cells, from a cell to a number or a time.
#include "cells.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>
#include <limits>

namespace binnacle::csv {

namespace {

__extension__ using Wide = unsigned __int128;

bool is_blank(char c) { return c == ' ' || c == '\t'; }

std::string_view trimmed(const char* begin, const char* end) {
  while (begin != end && is_blank(*begin)) ++begin;
  while (begin != end && is_blank(end[-1])) --end;
  return {begin, static_cast<std::size_t>(end - begin)};
}

std::string_view unquoted(std::string_view cell) {
  if (cell.size() < 2 || cell.front() != '"' || cell.back() != '"') return cell;
  cell = cell.substr(1, cell.size() - 2);
  return trimmed(cell.data(), cell.data() + cell.size());
}

void split_at_blanks(std::string_view line, std::vector<std::string_view>& cells) {
  const char* at = line.data();
  const char* const end = at + line.size();
  for (;;) {
    while (at != end && is_blank(*at)) ++at;
    if (at == end) return;
    const char* const start = at;
    bool inside_quotes = false;
    for (; at != end && (inside_quotes || !is_blank(*at)); ++at) inside_quotes ^= *at == '"';
    cells.push_back(unquoted({start, static_cast<std::size_t>(at - start)}));
  }
}

void split_quoted(std::string_view line, char delimiter, std::vector<std::string_view>& cells) {
  const char* start = line.data();
  const char* const end = start + line.size();
  bool inside_quotes = false;
  for (const char* at = start; at != end; ++at) {
    inside_quotes ^= *at == '"';
    if (*at != delimiter || inside_quotes) continue;
    cells.push_back(unquoted(trimmed(start, at)));
    start = at + 1;
  }
  cells.push_back(unquoted(trimmed(start, end)));
}

struct Decimal {
  bool negative = false;
  Wide digits = 0;   // at most 24 of them, which leaves room for a unit of up to 38 − 24 digits
  int exponent = 0;  // value = digits · 10^exponent
};

bool parse_exponent(const char*& at, const char* end, int& exponent) {
  if (at != end && *at == '+') {
    ++at;
    if (at != end && *at == '-') return false;
  }
  int given = 0;
  const auto [rest, error] = std::from_chars(at, end, given);
  if (error != std::errc() || given > 9999 || given < -9999) return false;
  exponent += given;
  at = rest;
  return true;
}

bool parse_decimal(std::string_view cell, Decimal& decimal) {
  constexpr int most_digits = 24;
  const char* at = cell.data();
  const char* const end = at + cell.size();
  if (at != end && (*at == '-' || *at == '+')) decimal.negative = *at++ == '-';
  std::uint64_t low = 0;  // the first 18 digits in cheap arithmetic
  int significant = 0;
  bool any_digit = false, after_point = false;
  for (; at != end; ++at) {
    if (*at == '.') {
      if (after_point) return false;
      after_point = true;
      continue;
    }
    if (*at < '0' || *at > '9') break;
    any_digit = true;
    const auto digit = static_cast<unsigned>(*at - '0');
    if (significant < most_digits) {
      if (significant < 18) {
        low = low * 10 + digit;
      } else {
        if (significant == 18) decimal.digits = low;
        decimal.digits = decimal.digits * 10 + digit;
      }
      if (significant > 0 || digit != 0) ++significant;
      if (after_point) --decimal.exponent;
    } else if (!after_point) {
      ++decimal.exponent;
    }
  }
  if (!any_digit) return false;
  if (significant <= 18) decimal.digits = low;
  if (at != end && (*at == 'e' || *at == 'E') && !parse_exponent(++at, end, decimal.exponent)) return false;
  return at == end;
}

bool multiply_by_ten(Wide& value, int times) {
  constexpr Wide limit = ~Wide{0} / 10;
  for (; times > 0 && value != 0; --times) {
    if (value > limit) return false;
    value *= 10;
  }
  return true;
}

constexpr auto powers_of_ten = [] {
  std::array<std::uint64_t, 20> powers{1};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = powers[i - 1] * 10;
  return powers;
}();

/// value / 10^power, half away from zero.
Wide divide_by_ten(Wide value, int power) {
  if (power > 38) return 0;
  const auto low = powers_of_ten[static_cast<std::size_t>(std::min(power, 19))];
  if (power <= 19 && (value >> 64) == 0) {
    const auto short_value = static_cast<std::uint64_t>(value);
    const std::uint64_t remainder = short_value % low;
    return short_value / low + (remainder >= low - remainder ? 1 : 0);
  }
  const Wide divisor = Wide{low} * powers_of_ten[static_cast<std::size_t>(power - std::min(power, 19))];
  const Wide remainder = value % divisor;
  return value / divisor + (remainder >= divisor - remainder ? 1 : 0);
}

std::string folded(std::string_view text) {
  std::string result;
  for (const char c : text)
    if (c != '_' && c != '-' && c != ' ') result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
    }
  }
  return row.back();
}

}  // namespace

void split(std::string_view line, char delimiter, std::vector<std::string_view>& cells) {
  cells.clear();
  if (delimiter == ' ') return split_at_blanks(line, cells);
  if (std::memchr(line.data(), '"', line.size())) return split_quoted(line, delimiter, cells);
  const char* start = line.data();
  const char* const end = start + line.size();
  while (const void* found = std::memchr(start, delimiter, static_cast<std::size_t>(end - start))) {
    const char* const at = static_cast<const char*>(found);
    cells.push_back(trimmed(start, at));
    start = at + 1;
  }
  cells.push_back(trimmed(start, end));
}

/// Plain decimals of few digits: both the digits and the power of ten are exact doubles, so that one division rounds
/// correctly (Clinger, "How to read floating point numbers accurately", PLDI 1990). False: not one of them.
bool parse_short_number(std::string_view cell, double& value) {
  const char* at = cell.data();
  const char* const end = at + cell.size();
  const bool is_negative = *at == '-';
  at += is_negative;
  if (end - at > 19 || at == end) return false;
  std::uint64_t digits = 0;
  const char* point = nullptr;
  for (const char* const start = at; at != end; ++at) {
    const auto digit = static_cast<unsigned>(*at - '0');
    if (digit <= 9) {
      digits = digits * 10 + digit;
    } else if (*at == '.' && !point && at != start) {
      point = at;
    } else {
      return false;
    }
  }
  if (digits > (std::uint64_t{1} << 53)) return false;
  value = static_cast<double>(digits);
  if (point) value /= exact_powers_of_ten[static_cast<std::size_t>(end - point - 1)];
  if (is_negative) value = -value;
  return true;
}

CellFault parse_number(std::string_view cell, double& value) {
  if (cell.empty()) return CellFault::empty;
  if (parse_short_number(cell, value)) return CellFault::none;
  const char* begin = cell.data();
  const char* const end = begin + cell.size();
  if (*begin == '+' && cell.size() > 1 && begin[1] != '-') ++begin;
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (error == std::errc::invalid_argument || rest != end) return CellFault::not_a_number;
  if (error == std::errc::result_out_of_range) {
    Decimal decimal;
    const bool is_known = parse_decimal(cell, decimal);
    const bool is_small =
        is_known ? decimal.exponent < 0 : cell.find("e-") != cell.npos || cell.find("E-") != cell.npos;
    if (!is_small) return CellFault::out_of_range;
    value = *begin == '-' ? -0.0 : 0.0;  // too small for a double
  }
  return CellFault::none;
}

CellFault parse_time(std::string_view cell, std::int64_t unit, Time& value) {
  if (cell.empty()) return CellFault::empty;
  Decimal decimal;
  if (!parse_decimal(cell, decimal)) return CellFault::not_a_number;
  while (decimal.exponent < 0 && unit % 10 == 0) {  // 1e9 / 10^12 is 1 / 10^3
    unit /= 10;
    ++decimal.exponent;
  }
  Wide magnitude = decimal.digits * static_cast<Wide>(unit);
  if (!multiply_by_ten(magnitude, decimal.exponent)) return CellFault::out_of_range;
  if (decimal.exponent < 0) magnitude = divide_by_ten(magnitude, -decimal.exponent);
  if (magnitude > static_cast<Wide>(std::numeric_limits<Time>::max())) return CellFault::out_of_range;
  value = static_cast<Time>(magnitude);
  if (decimal.negative) value = -value;
  return CellFault::none;
}

std::string time_text(Time t) {
  const std::uint64_t magnitude = t < 0 ? 0 - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  std::string text = (t < 0 ? "-" : "") + std::to_string(magnitude / 1'000'000'000);
  if (const std::uint64_t fraction = magnitude % 1'000'000'000) {
    std::string digits = std::to_string(fraction);
    digits.insert(0, 9 - digits.size(), '0');
    digits.erase(digits.find_last_not_of('0') + 1);
    text += "." + digits;
  }
  return text + " s";
}

std::string closest(std::string_view name, const std::vector<std::string>& candidates) {
  const std::string wanted = folded(name);
  std::string best;
  std::size_t best_distance = wanted.size() / 3 + 1;
  for (const auto& candidate : candidates) {
    const std::string offered = folded(candidate);
    const bool continues = !wanted.empty() && offered.compare(0, wanted.size(), wanted) == 0;
    const std::size_t distance = continues ? 1 : edit_distance(wanted, offered);
    if (distance < best_distance || (distance == best_distance && best.empty())) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace binnacle::csv
