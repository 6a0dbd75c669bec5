// SPDX-License-Identifier: Apache-2.0
// Units: scales against exact arithmetic, the grammar, the messages of mistakes, and exact times.
#include "binnacle/unit.hpp"
#include "binnacle/time.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"

namespace unit_test {

using namespace binnacle;

namespace {

constexpr long double pi = std::numbers::pi_v<long double>;

Unit unit(const std::string& text) {
  INFO(text);
  const Parsed<Unit> parsed = parse_unit(text);
  INFO(parsed.error());
  REQUIRE(parsed);
  return *parsed;
}

bool is_nearest(double value, long double exact) {
  return std::abs(static_cast<long double>(value) - exact) <=
         std::abs(exact) * static_cast<long double>(std::numeric_limits<double>::epsilon()) / 2.0L * 1.0001L;
}

double quantity(const std::string& text) { return parse_quantity(text)->value; }

std::string unit_error(const std::string& text) { return parse_unit(text).error(); }
std::string quantity_error(const std::string& text) { return parse_quantity(text).error(); }

}  // namespace

TEST_CASE("the scale of a unit is the double nearest to the exact one", "[unit]") {
  const std::vector<std::pair<std::string, long double>> exact{
      {"deg", pi / 180},
      {"arcmin", pi / 10800},
      {"arcsec", pi / 648000},
      {"mil", 2 * pi / 6400},
      {"mrad", 1e-3L},
      {"h", 3600},
      {"min", 60},
      {"day", 86400},
      {"sqrt(h)", 60},
      {"deg/h", pi / 648000},
      {"deg/sqrt(h)", pi / 10800},
      {"deg/h/sqrt(Hz)", pi / 648000},
      {"m/s/h", 1.0L / 3600},
      {"m/s/sqrt(h)", 1.0L / 60},
      {"g", 9.80665L},
      {"mg", 9.80665e-3L},
      {"ug", 9.80665e-6L},
      {"ug/sqrt(Hz)", 9.80665e-6L},
      {"mGal", 1e-5L},
      {"km/h", 1.0L / 3.6L},
      {"kn", 1852.0L / 3600},
      {"nmi", 1852},
      {"ft", 0.3048L},
      {"ppm", 1e-6L},
      {"%", 1e-2L},
      {"1", 1},
      {"hPa", 100},
      {"uT", 1e-6L},
      {"kHz", 1000},
      {"cm^2", 1e-4L},
      {"deg^2", (pi / 180) * (pi / 180)},
  };
  for (const auto& [text, scale] : exact) {
    INFO(text);
    CHECK(is_nearest(unit(text).scale, scale));
  }
}

TEST_CASE("division goes from left to right", "[unit]") {
  CHECK(unit("m/s/s").dimension == unit("m/s^2").dimension);
  CHECK(unit("m/s*s").dimension == unit("m").dimension);
  CHECK(unit("m/(s*s)").dimension == unit("m*s^-2").dimension);
  CHECK(unit("kg.m/s^2").dimension == unit("N").dimension);
  CHECK(unit("1/s").dimension == unit("Hz").dimension);
  CHECK(unit("sqrt(m^2/s^3)").dimension == unit("m/s/sqrt(s)").dimension);
  CHECK(unit("rad/s/sqrt(Hz)").dimension == unit("deg/sqrt(h)").dimension);
  CHECK(unit("ug/sqrt(Hz)").dimension == unit("m/s/sqrt(h)").dimension);
  CHECK(unit("min").dimension == unit("s").dimension);
}

TEST_CASE("an angle is not a plain number", "[unit]") {
  CHECK_FALSE(unit("deg").dimension == unit("1").dimension);
  CHECK_FALSE(unit("rad/s").dimension == unit("Hz").dimension);
  CHECK(unit("ppm").dimension.is_dimensionless());
}

TEST_CASE("canonical texts are read back with scale one", "[unit]") {
  for (const char* text :
       {"1",       "m",      "s",   "rad",       "rad/s",   "m/s^2", "rad/sqrt(s)", "m/s/sqrt(s)", "rad/s/sqrt(s)",
        "m^2/s^3", "rad^2",  "1/s", "1/sqrt(s)", "sqrt(s)", "m*rad", "N",           "Pa",          "T",
        "V",       "kg*m^2", "K",   "A"}) {
    CHECK(si_unit(unit(text).dimension) == text);
    CHECK(unit(text).scale == 1.0);
  }
}

TEST_CASE("every dimension of small exponents survives its text", "[unit]") {
  for (int length = -4; length <= 4; ++length) {
    for (int time = -5; time <= 5; ++time) {
      for (int angle = -3; angle <= 3; ++angle) {
        const Dimension dimension{{length, time, angle, 0, 0, 0}};
        INFO(si_unit(dimension));
        const auto back = parse_unit(si_unit(dimension));
        REQUIRE(back);
        CHECK(back->dimension == dimension);
        CHECK(back->scale == 1.0);
      }
    }
  }
}

TEST_CASE("dimensions have names for messages", "[unit]") {
  CHECK(dimension_name(unit("deg/h").dimension) == "an angular rate (rad/s)");
  CHECK(dimension_name(unit("mg").dimension) == "an acceleration (m/s^2)");
  CHECK(dimension_name(unit("deg/sqrt(h)").dimension) == "an angle random walk (rad/sqrt(s))");
  CHECK(dimension_name(unit("ppm").dimension) == "a plain number");
  CHECK(dimension_name(unit("m^3/kg").dimension) == "a quantity in m^3/kg");
}

TEST_CASE("a unit that is none says what is wrong", "[unit]") {
  CHECK(unit_error("deg/hr") == "unknown unit 'deg/hr'; did you mean 'deg/h'?");
  CHECK(unit_error("degrees/hour") == "unknown unit 'degrees/hour'; did you mean 'deg/h'?");
  CHECK(unit_error("hz") == "unknown unit 'hz'; did you mean 'Hz'?");
  CHECK(unit_error("m/sec^2") == "unknown unit 'm/sec^2'; did you mean 'm/s^2'?");
  CHECK(unit_error("deg/rthr") == "unknown unit 'deg/rthr'; did you mean 'deg/sqrt(h)'?");
  CHECK(unit_error("degC") == "unknown unit 'degC'; a temperature is given in kelvin, 'K'");
  CHECK(unit_error("furlong") == "unknown unit 'furlong'");
  CHECK(unit_error("furlong/day") == "unknown unit 'furlong/day' ('furlong')");
  CHECK(unit_error("m/s2") == "unit 'm/s2' has an unexpected '2'; a power is written '^2'");
  CHECK(unit_error("m s") == "unit 'm s' has an unexpected ' '; write '*' for a product");
  CHECK(unit_error("m/") == "unit 'm/' ends where a unit is expected");
  CHECK(unit_error("deg/sqrt(h") == "unit 'deg/sqrt(h' lacks a ')'");
  CHECK(unit_error("Hz^0.5") == "unit 'Hz^0.5' has a power that is not a whole number; a root is written sqrt(...)");
  CHECK(unit_error("sqrt(sqrt(m))") == "unit 'sqrt(sqrt(m))' has a root of a root");
  CHECK(unit_error("m^99") == "unit 'm^99' has an exponent out of range");
  CHECK(unit_error("") == "empty unit; a number without a unit is '1'");
  CHECK_FALSE(parse_unit("kdeg"));
  CHECK_FALSE(parse_unit(std::string(200, '(')));
}

TEST_CASE("a quantity is a number and a unit", "[unit]") {
  CHECK(is_nearest(quantity("0.2 deg/h"), static_cast<long double>(0.2) * pi / 648000));
  CHECK(quantity("300 ms") == 0.3);
  CHECK(quantity("1e-3 m") == 1e-3);
  CHECK(quantity("1e-3m") == 1e-3);
  CHECK(quantity("-5m") == -5.0);
  CHECK(quantity("+5 m") == 5.0);
  CHECK(quantity(".5 m") == 0.5);
  CHECK(quantity("  2 h ") == 7200.0);
  CHECK(quantity("200 ppm") == 200e-6);
  CHECK(quantity("4") == 4.0);
  CHECK(parse_quantity("4")->dimension.is_dimensionless());
}

TEST_CASE("a malformed quantity says what is wrong", "[unit]") {
  CHECK(quantity_error("0.2 deg/hr") == "unknown unit 'deg/hr'; did you mean 'deg/h'?");
  CHECK(quantity_error("") == "empty text; expected a number with a unit, such as '0.2 deg/h'");
  CHECK(quantity_error("deg") == "'deg' does not begin with a number; expected something like '0.2 deg/h'");
  CHECK(quantity_error("inf m") == "'inf m' does not begin with a number; expected something like '0.2 deg/h'");
  CHECK(quantity_error("-nan") == "'-nan' does not begin with a number; expected something like '0.2 deg/h'");
  CHECK(quantity_error("1e999 m") == "the number of '1e999 m' is out of range");
  CHECK(quantity_error("1e308 km") == "'1e308 km' is out of range");
  CHECK(quantity_error("0,2 m") == "the decimal point of '0,2 m' is a comma");
  CHECK(quantity_error("1 m 2") == "unit 'm 2' has an unexpected ' '; write '*' for a product");
}

TEST_CASE("times are exact to the nanosecond", "[unit]") {
  CHECK(*parse_time("228 s") == 228'000'000'000);
  CHECK(*parse_time("1.5 h") == 5'400'000'000'000);
  CHECK(*parse_time("-20 ms") == -20'000'000);
  CHECK(*parse_time("1 day") == 86'400'000'000'000);
  CHECK(*parse_time("2 min") == 120'000'000'000);
  CHECK(*parse_time("7ns") == 7);
  CHECK(*parse_time("1e-3 us") == 1);
  CHECK(*parse_time("1700000000.123456789 s") == 1'700'000'000'123'456'789);
  CHECK(*parse_time("0.4 ns") == 0);
  CHECK(*parse_time("0.5 ns") == 1);
  CHECK(*parse_time("-0.5 ns") == -1);
  CHECK(*parse_time("0.0000000000000000001 s") == 0);
  CHECK(*parse_time("4000000000.123456789 s") == 4'000'000'000'123'456'789);
  CHECK(*parse_time("0.000277777777778 h") == 1'000'000'000);
  CHECK(parse_time("1 1/Hz").error() == "unit '1/Hz' is not a time; use ns, us, ms, s, min, h or day");
  CHECK(parse_time("228").error() == "'228' has no unit; write '228 s'");
  CHECK(parse_time("5 m").error() == "unit 'm' is not a time; use ns, us, ms, s, min, h or day");
  CHECK(parse_time("soon").error() == "'soon' does not begin with a number; expected something like '120 s'");
  CHECK(parse_time("1e30 s").error() == "the time '1e30 s' is beyond 146 years");
}

TEST_CASE("seconds and nanoseconds agree", "[unit]") {
  CHECK(from_seconds(0.1) == 100'000'000);
  CHECK(from_seconds(-0.1) == -100'000'000);
  CHECK(from_seconds(1e9 + 0.5) == 1'000'000'000'500'000'000);
  for (std::int64_t t = -5'000'000'000; t < 5'000'000'000; t += 123'456'789) CHECK(from_seconds(seconds(t)) == t);
  CHECK_THROWS_AS(from_seconds(1e10), std::out_of_range);
  CHECK_THROWS_AS(from_seconds(std::nan("")), std::out_of_range);
}

TEST_CASE("SI goes back to the unit for display", "[unit]") {
  CHECK(std::abs(quantity("0.2 deg/h") / unit("deg/h").scale - 0.2) < 1e-15);
  CHECK(7200.0 / unit("h").scale == 2.0);
}

}  // namespace unit_test
