// SPDX-License-Identifier: Apache-2.0
// Numbers of a CSV: std::to_chars is the oracle.
#include "number_text.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>

#include "catch.hpp"
#include "csv_records.hpp"

namespace number_text_test {

using namespace binnacle;
using command::Digits;

namespace {

std::string text_of(double value, Digits digits) {
  char text[command::longest_number];
  return {text, command::put_number(text, value, digits)};
}

std::string seconds_text(Time t) {
  char text[command::longest_number];
  return {text, command::put_seconds(text, t)};
}

std::string without_zeros(std::string text) {
  if (text.find('.') == text.npos || text.find('e') != text.npos) return text;
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

template <class... Format>
std::string standard(double value, Format... format) {
  char text[command::longest_number];
  return {text, std::to_chars(text, text + sizeof text, value, format...).ptr};
}

std::string expected(double value, Digits digits) {
  if (value == 0) return "0";
  if (!std::isfinite(value) || digits.decimals == Digits::shortest) return standard(value);
  const bool is_small = digits.decimals == Digits::none ||
                        std::abs(value) * std::pow(10, digits.decimals) < std::pow(10, digits.significant - 1);
  if (is_small) return standard(value, std::chars_format::general, digits.significant);
  return without_zeros(standard(value, std::chars_format::fixed, digits.decimals));
}

}  // namespace

TEST_CASE("numbers are those of to_chars to so many digits, without zeros at the end") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> mantissa(1, 10), exponent(-30, 30);
  for (int i = 0; i < 1'000'000; ++i) {
    double value = std::bit_cast<double>(random());  // of any size
    if (i % 4 == 1) value = mantissa(random) * std::pow(10, exponent(random) / (i % 8 == 1 ? 1 : 5));
    if (i % 4 == 2)
      value = static_cast<double>(static_cast<int>(random() % 20'000'001) - 10'000'000) / (1 << random() % 24);
    if (i % 4 == 3) value = static_cast<double>(random() % 100'000'000) / 1e4;  // whole digits, ties among them
    const Digits digits{random() % 4 == 0 ? Digits::none : static_cast<int>(random() % 13),
                        static_cast<int>(5 + random() % 4)};
    if (text_of(value, digits) == expected(value, digits)) continue;
    CAPTURE(value, digits.decimals, digits.significant);
    REQUIRE(text_of(value, digits) == expected(value, digits));
  }
}

TEST_CASE("numbers at the edges of the fast ways") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  CHECK(text_of(0, {4}) == "0");
  CHECK(text_of(-0.0, {4}) == "0");
  CHECK(text_of(std::nan(""), {4}) == "nan");
  CHECK(text_of(-infinity, {Digits::none, 5}) == "-inf");
  CHECK(text_of(0.125, {2, 1}) == "0.12");  // ties go to even digits
  CHECK(text_of(0.375, {2, 1}) == "0.38");
  CHECK(text_of(99.99996, {4}) == "100");
  CHECK(text_of(-520.00004, {4}) == "-520");
  CHECK(text_of(0.99999999, {Digits::none, 5}) == "1");
  CHECK(text_of(99999.6, {Digits::none, 5}) == "1e+05");
  CHECK(text_of(123456.7, {Digits::none, 5}) == "1.2346e+05");
  CHECK(text_of(7.83927e-8, {Digits::none, 5}) == "7.8393e-08");
  CHECK(text_of(1.5e-5, {4}) == "1.5e-05");
  CHECK(text_of(4294967295.99999, {4}) == "4294967296");
  CHECK(text_of(1e18, {4}) == "1000000000000000000");
  CHECK(text_of(5e-324, {12, 6}) == "4.94066e-324");
  for (const double value : {std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest(),
                             std::numeric_limits<double>::min(), 0.1, 1.0 / 3})
    CHECK(std::strtod(text_of(value, {Digits::shortest}).c_str(), nullptr) == value);
}

TEST_CASE("seconds are written to the nanosecond, by integers") {
  CHECK(seconds_text(0) == "0.000000000");
  CHECK(seconds_text(1) == "0.000000001");
  CHECK(seconds_text(-1'500'000'000) == "-1.500000000");
  CHECK(seconds_text(1'600'000'000'123'456'789) == "1600000000.123456789");
  CHECK(seconds_text(std::numeric_limits<Time>::min()) == "-9223372036.854775808");
}

TEST_CASE("digits of a column go by its unit, and five are enough of a sigma") {
  const auto text = [](const char* name, const char* unit, double value) {
    return text_of(value, command::digits_of({name, unit}));
  };
  CHECK(text("position.lat", "rad", 0.8401491234567891) == "0.84014912346");
  CHECK(text("position.lat.sigma", "rad", 7.839271234e-8) == "7.8393e-08");
  CHECK(text("position.height", "m", 520.123456789) == "520.1235");
  CHECK(text("velocity.vn", "m/s", -13.987654321) == "-13.987654");
  CHECK(text("gyro_bias.x0", "rad/s", 4.8481368e-4) == "0.000484814");
  CHECK(text("gyro_bias.x0", "rad/s", 4.848136811e-6) == "4.84814e-06");  // six remain of what is small
  CHECK(text("accel_bias.x0", "m/s^2", 0.0294199512345) == "0.02942");
  CHECK(text("fix.noise", "m", 1.23456789) == "1.2346");
  CHECK(text("pressure.x", "Pa", 101325.12345678901) == "101325.123456789");  // no digits are known to suffice
}

}  // namespace number_text_test
