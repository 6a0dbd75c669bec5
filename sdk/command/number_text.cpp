// SPDX-License-Identifier: Apache-2.0
#include "number_text.hpp"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace binnacle::command {

namespace {

constexpr std::array<char, 200> make_pairs() {
  std::array<char, 200> pairs{};
  for (std::size_t i = 0; i < 100; ++i) {
    pairs[2 * i] = static_cast<char>('0' + i / 10);
    pairs[2 * i + 1] = static_cast<char>('0' + i % 10);
  }
  return pairs;
}
constexpr auto pairs = make_pairs();

/// Powers of ten that a double holds exactly.
constexpr int most_exact = 22;
constexpr std::array<double, most_exact + 1> make_powers() {
  std::array<double, most_exact + 1> powers{1.0};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = powers[i - 1] * 10;
  return powers;
}
constexpr auto powers = make_powers();

double power(int exponent) { return powers[static_cast<std::size_t>(exponent)]; }

void put_pair(char* at, std::uint32_t n) { std::memcpy(at, pairs.data() + 2 * std::size_t{n}, 2); }

void put_four(char* at, std::uint32_t n) {
  put_pair(at, n / 100);
  put_pair(at + 2, n % 100);
}

void put_eight(char* at, std::uint32_t n) {
  put_four(at, n / 10'000);
  put_four(at + 4, n % 10'000);
}

char* put_natural(char* at, std::uint64_t n) {
  if (n < 10) {
    *at = static_cast<char>('0' + n);
    return at + 1;
  }
  return std::to_chars(at, at + 20, n).ptr;
}

char* without_zeros(char* end) {
  while (end[-1] == '0') --end;
  return end;
}

char* put_shortest(char* at, double value) { return std::to_chars(at, at + longest_number, value).ptr; }

/// What is too large or too near to a tie for the fast ways.
char* put_slowly(char* at, double value, std::chars_format format, int precision) {
  char* const end = std::to_chars(at, at + longest_number, value, format, precision).ptr;
  if (format == std::chars_format::general || precision == 0) return end;
  char* const cut = without_zeros(end);
  return cut[-1] == '.' ? cut - 1 : cut;
}

/// Rounded to an integer, where it is certain how the exact product would be rounded.
struct Rounded {
  std::uint64_t n;
  bool is_certain;
};
Rounded rounded(double product) {
  const auto whole = static_cast<std::uint64_t>(product);
  const double rest = product - static_cast<double>(whole);
  // The product is off by half a unit of its last bit at most.
  const bool is_certain = std::abs(rest - 0.5) > product * 0x1p-52;
  return {whole + (rest > 0.5 ? 1 : 0), is_certain};
}

/// As "%.*f" without zeros at the end, of a number below 2^32.
char* put_fixed(char* at, double magnitude, double signed_value, int decimals) {
  auto whole = static_cast<std::uint64_t>(magnitude);
  auto [n, is_certain] = rounded((magnitude - static_cast<double>(whole)) * power(decimals));
  if (!is_certain) return put_slowly(at, signed_value, std::chars_format::fixed, decimals);
  *at = '-';
  at += signed_value < 0;
  if (static_cast<double>(n) >= power(decimals)) {
    ++whole;
    n = 0;
  }
  at = put_natural(at, whole);
  if (n == 0) return at;
  char text[16];
  put_four(text, static_cast<std::uint32_t>(n / 100'000'000));
  put_eight(text + 4, static_cast<std::uint32_t>(n % 100'000'000));
  *at++ = '.';
  std::memcpy(at, text + Digits::most_decimals - decimals, static_cast<std::size_t>(decimals));
  return without_zeros(at + decimals);
}

/// n / 10^(significant - 1) * 10^exponent as "%g" has it.
char* lay_out(char* at, std::uint64_t n, int exponent, int significant) {
  char text[8];
  put_eight(text, static_cast<std::uint32_t>(n));
  const char* const first = text + 8 - significant;
  int digits = significant;
  while (first[digits - 1] == '0') --digits;
  const auto copy = [&](const char* from, int count) {
    std::memcpy(at, from, static_cast<std::size_t>(count));
    at += count;
  };
  if (exponent >= 0 && exponent < significant) {
    copy(first, exponent + 1);
    if (digits <= exponent + 1) return at;
    *at++ = '.';
    copy(first + exponent + 1, digits - exponent - 1);
    return at;
  }
  if (exponent < 0 && exponent >= -4) {
    copy("0.000", 1 - exponent);
    copy(first, digits);
    return at;
  }
  *at++ = *first;
  if (digits > 1) {
    *at++ = '.';
    copy(first + 1, digits - 1);
  }
  *at++ = 'e';
  *at++ = exponent < 0 ? '-' : '+';
  const int magnitude = exponent < 0 ? -exponent : exponent;
  put_pair(at, static_cast<std::uint32_t>(magnitude));
  return at + 2;
}

/// As "%.*g", of a finite number that is not 0.
char* put_significant(char* at, double magnitude, double signed_value, int significant) {
  const int binary = static_cast<int>(std::bit_cast<std::uint64_t>(magnitude) >> 52) - 1023;
  // floor(log10) of it, or one less: log10(2) = 1233/4096 to five digits.
  int exponent = binary * 1233 >> 12;
  for (int tries = 0; tries < 2; ++tries, ++exponent) {
    const int shift = significant - 1 - exponent;
    if (shift > most_exact || shift < -most_exact) break;
    const double product = shift >= 0 ? magnitude * power(shift) : magnitude / power(-shift);
    if (product >= power(significant)) continue;
    auto [n, is_certain] = rounded(product);
    if (!is_certain) break;
    *at = '-';
    at += signed_value < 0;
    if (static_cast<double>(n) >= power(significant)) {
      n /= 10;
      ++exponent;
    }
    return lay_out(at, n, exponent, significant);
  }
  return put_slowly(at, signed_value, std::chars_format::general, significant);
}

}  // namespace

char* put_number(char* at, double value, Digits digits) {
  if (digits.decimals == Digits::shortest) return put_shortest(at, value);
  if (value == 0) {
    *at = '0';
    return at + 1;
  }
  const double magnitude = std::abs(value);
  if (!std::isfinite(magnitude)) return put_shortest(at, value);
  if (digits.decimals == Digits::none || magnitude * power(digits.decimals) < power(digits.significant - 1))
    return put_significant(at, magnitude, value, digits.significant);
  if (magnitude < 0x1p32) return put_fixed(at, magnitude, value, digits.decimals);
  return put_slowly(at, value, std::chars_format::fixed, digits.decimals);
}

char* put_seconds(char* at, Time t) {
  constexpr std::uint64_t second = nanoseconds_per_second;
  // The magnitude as unsigned: the smallest Time has no negative.
  const auto magnitude = t < 0 ? 0 - static_cast<std::uint64_t>(t) : static_cast<std::uint64_t>(t);
  *at = '-';
  at = put_natural(at + (t < 0), magnitude / second);
  const auto rest = static_cast<std::uint32_t>(magnitude % second);
  *at++ = '.';
  *at = static_cast<char>('0' + rest / 100'000'000);
  put_eight(at + 1, rest % 100'000'000);
  return at + 9;
}

}  // namespace binnacle::command
