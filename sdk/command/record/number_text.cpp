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

static_assert(std::endian::native == std::endian::little, "the first digit is the lowest byte");

/// Eight decimal digits as bytes, the first in the lowest. Halves, then quarters, then digits are divided in all lanes at once;
/// kept in a register, since small stores that a longer load follows cost more than the digits.
std::uint64_t eight_digits(std::uint64_t n) {
  std::uint64_t lanes = n / 10'000 | n % 10'000 << 32;
  std::uint64_t tops = lanes * 10486 >> 20 & 0x7f0000007f;
  lanes = tops | (lanes - 100 * tops) << 16;
  tops = lanes * 103 >> 10 & 0xf000f000f000f;
  return tops | (lanes - 10 * tops) << 8;
}

/// Their characters; eight bytes are written, whatever counts of them.
void put_digits(char* at, std::uint64_t digits) {
  digits |= 0x3030303030303030;
  std::memcpy(at, &digits, sizeof digits);
}

/// Without the zeros at the end; 0 of none.
int count_of(std::uint64_t digits) { return 8 - std::countl_zero(digits) / 8; }

/// Powers of ten that a double holds exactly.
constexpr int most_exact = 22;
constexpr std::array<double, most_exact + 1> make_powers() {
  std::array<double, most_exact + 1> powers{1.0};
  for (std::size_t i = 1; i < powers.size(); ++i) powers[i] = powers[i - 1] * 10;
  return powers;
}
constexpr auto powers = make_powers();

double power(int exponent) { return powers[static_cast<std::size_t>(exponent)]; }

char* put_natural(char* at, std::uint64_t n) {
  *at = static_cast<char>('0' + n);
  if (n < 10) return at + 1;
  if (n >= 100'000'000) return std::to_chars(at, at + 20, n).ptr;
  const std::uint64_t digits = eight_digits(n);
  const int zeros = std::countr_zero(digits) / 8;
  put_digits(at, digits >> 8 * zeros);
  return at + 8 - zeros;
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
  std::int64_t n;  // signed: processors convert these at once
  bool is_certain;
};
Rounded rounded(double product) {
  const auto whole = static_cast<std::int64_t>(product);
  const double rest = product - static_cast<double>(whole);
  // The product is off by half a unit of its last bit at most.
  const bool is_certain = std::abs(rest - 0.5) > product * 0x1p-52;
  return {whole + (rest > 0.5 ? 1 : 0), is_certain};
}

/// As "%.*f" without zeros at the end, of a number below 2^32.
char* put_fixed(char* at, double magnitude, double signed_value, int decimals) {
  auto whole = static_cast<std::int64_t>(magnitude);
  auto [n, is_certain] = rounded((magnitude - static_cast<double>(whole)) * power(decimals));
  if (!is_certain) return put_slowly(at, signed_value, std::chars_format::fixed, decimals);
  *at = '-';
  at += signed_value < 0;
  if (static_cast<double>(n) >= power(decimals)) {
    ++whole;
    n = 0;
  }
  at = put_natural(at, static_cast<std::uint64_t>(whole));
  if (n == 0) return at;
  const auto fraction = static_cast<std::uint64_t>(n);
  *at++ = '.';
  if (decimals <= 8) {
    const std::uint64_t digits = eight_digits(fraction) >> 8 * (8 - decimals);
    put_digits(at, digits);
    return at + count_of(digits);
  }
  const int before = decimals - 8;
  const std::uint64_t first = eight_digits(fraction / 100'000'000) >> 8 * (8 - before),
                      last = eight_digits(fraction % 100'000'000);
  put_digits(at, first);
  if (last == 0) return at + count_of(first);
  put_digits(at + before, last);
  return at + before + count_of(last);
}

/// n / 10^(significant - 1) * 10^exponent as "%g" has it.
char* lay_out(char* at, std::uint64_t n, int exponent, int significant) {
  const std::uint64_t digits = eight_digits(n) >> 8 * (8 - significant);
  const int count = count_of(digits);
  if (exponent >= 0 && exponent < significant) {
    const int whole = exponent + 1;
    put_digits(at, digits);
    if (count <= whole) return at + whole;
    at[whole] = '.';
    put_digits(at + whole + 1, whole < 8 ? digits >> 8 * whole : 0);
    return at + count + 1;
  }
  if (exponent < 0 && exponent >= -4) {
    std::memcpy(at, "0.000\0\0\0", 8);
    put_digits(at + 1 - exponent, digits);
    return at + 1 - exponent + count;
  }
  put_digits(at, digits);
  if (count > 1) {
    at[1] = '.';
    put_digits(at + 2, digits >> 8);
  }
  at += count > 1 ? count + 1 : 1;
  *at++ = 'e';
  *at++ = exponent < 0 ? '-' : '+';
  const int magnitude = exponent < 0 ? -exponent : exponent;
  *at++ = static_cast<char>('0' + magnitude / 10);
  *at++ = static_cast<char>('0' + magnitude % 10);
  return at;
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
    return lay_out(at, static_cast<std::uint64_t>(n), exponent, significant);
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
  const std::uint64_t rest = magnitude % second;
  *at++ = '.';
  *at = static_cast<char>('0' + rest / 100'000'000);
  put_digits(at + 1, eight_digits(rest % 100'000'000));
  return at + 9;
}

}  // namespace binnacle::command
