// SPDX-License-Identifier: Apache-2.0
#include "number_text.hpp"

#include <charconv>
#include <cmath>
#include <cstdint>

namespace binnacle::command {

namespace {

constexpr double powers[] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12};

char* put(char* at, double value, std::chars_format format, int precision) {
  return std::to_chars(at, at + longest_number, value, format, precision).ptr;
}

/// Without zeros at the end of a fraction, and without its point if nothing is left of it.
char* without_zeros(char* end) {
  while (end[-1] == '0') --end;
  return end[-1] == '.' ? end - 1 : end;
}

}  // namespace

char* put_number(char* at, double value, Digits digits) {
  if (value == 0 && digits.decimals != Digits::shortest) {
    *at = '0';
    return at + 1;
  }
  if (digits.decimals == Digits::shortest || !std::isfinite(value))
    return std::to_chars(at, at + longest_number, value).ptr;
  const bool is_small =
      digits.decimals == Digits::none || std::abs(value) * powers[digits.decimals] < powers[digits.significant - 1];
  if (is_small) return put(at, value, std::chars_format::general, digits.significant);
  char* const end = put(at, value, std::chars_format::fixed, digits.decimals);
  return digits.decimals == 0 ? end : without_zeros(end);
}

char* put_seconds(char* at, Time t) {
  constexpr std::uint64_t second = nanoseconds_per_second;
  // The magnitude as unsigned: the smallest Time has no negative.
  const auto magnitude = t < 0 ? 0 - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  *at = '-';
  at = std::to_chars(at + (t < 0), at + longest_number, magnitude / second).ptr;
  // Ten digits, the first of which gives way to the point.
  std::to_chars(at, at + longest_number, second + magnitude % second);
  *at = '.';
  return at + 10;
}

}  // namespace binnacle::command
