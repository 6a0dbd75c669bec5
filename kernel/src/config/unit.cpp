// SPDX-License-Identifier: Apache-2.0
// Units: the table, the grammar, and the texts that go with a dimension.
#include "binnacle/unit.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <vector>

#include "base/text.hpp"
#include "base/time_range.hpp"
#include "binnacle/diagnostic.hpp"

namespace binnacle {

Dimension operator*(const Dimension& a, const Dimension& b) {
  Dimension product;
  std::ranges::transform(a.doubled, b.doubled, product.doubled.begin(), std::plus());
  return product;
}

Dimension operator/(const Dimension& a, const Dimension& b) {
  Dimension quotient;
  std::ranges::transform(a.doubled, b.doubled, quotient.doubled.begin(), std::minus());
  return quotient;
}

namespace {

// Scales are carried in long double, so that the double which leaves here is the nearest one: "300 ms" is 0.3.
struct Measure {
  long double scale = 1.0L;
  Dimension dimension;
};

struct KnownUnit {
  std::string_view name;
  Measure measure;
  std::string_view prefixes = {};
  std::string_view quantity = {};  // what is measured, of one unit for each dimension
};

constexpr Dimension dimension(int m, int s, int rad = 0, int kg = 0, int kelvin = 0, int ampere = 0) {
  return {{2 * m, 2 * s, 2 * rad, 2 * kg, 2 * kelvin, 2 * ampere}};
}

constexpr long double pi = std::numbers::pi_v<long double>;
constexpr long double standard_gravity = 9.80665L;  // m/s^2, 3rd CGPM (1901)

// clang-format off
constexpr KnownUnit named_units[] = {
    {"1", {1.0L, {}}}, {"%", {1e-2L, {}}}, {"ppm", {1e-6L, {}}}, {"ppb", {1e-9L, {}}},
    {"m", {1.0L, dimension(1, 0)}, "numck", "a length"}, {"s", {1.0L, dimension(0, 1)}, "num", "a time"},
    {"min", {60.0L, dimension(0, 1)}}, {"h", {3600.0L, dimension(0, 1)}}, {"day", {86400.0L, dimension(0, 1)}},
    {"Hz", {1.0L, dimension(0, -1)}, "mkMG", "a frequency or rate"},
    {"rad", {1.0L, dimension(0, 0, 1)}, "num", "an angle"}, {"deg", {pi / 180.0L, dimension(0, 0, 1)}, "um"},
    {"arcmin", {pi / 10800.0L, dimension(0, 0, 1)}}, {"arcsec", {pi / 648000.0L, dimension(0, 0, 1)}, "um"},
    {"mil", {pi / 3200.0L, dimension(0, 0, 1)}}, {"gon", {pi / 200.0L, dimension(0, 0, 1)}, "m"},
    {"g", {standard_gravity, dimension(1, -2)}, "num", "an acceleration"}, {"Gal", {1e-2L, dimension(1, -2)}, "um"},
    {"kn", {1852.0L / 3600.0L, dimension(1, -1)}, "", "a velocity"}, {"nmi", {1852.0L, dimension(1, 0)}},
    {"ft", {0.3048L, dimension(1, 0)}}, {"kg", {1.0L, dimension(0, 0, 0, 1)}, "", "a mass"},
    {"K", {1.0L, dimension(0, 0, 0, 0, 1)}, "um", "a temperature"},
    {"A", {1.0L, dimension(0, 0, 0, 0, 0, 1)}, "numk", "a current"},
    {"N", {1.0L, dimension(1, -2, 0, 1)}, "umk", "a force"},
    {"Pa", {1.0L, dimension(-1, -2, 0, 1)}, "mhkM", "a pressure"},
    {"T", {1.0L, dimension(0, -2, 0, 1, 0, -1)}, "num", "a magnetic flux density"},
    {"V", {1.0L, dimension(2, -3, 0, 1, 0, -1)}, "numk", "a voltage"},
};
// clang-format on

/// Spellings that are common elsewhere and that a search by edits would miss.
constexpr std::pair<std::string_view, std::string_view> other_spellings[] = {
    {"hr", "h"},          {"hrs", "h"},        {"hour", "h"},      {"hours", "h"},          {"sec", "s"},
    {"secs", "s"},        {"second", "s"},     {"seconds", "s"},   {"minute", "min"},       {"minutes", "min"},
    {"mins", "min"},      {"d", "day"},        {"days", "day"},    {"degree", "deg"},       {"degrees", "deg"},
    {"degs", "deg"},      {"\xC2\xB0", "deg"}, {"rads", "rad"},    {"radian", "rad"},       {"radians", "rad"},
    {"meter", "m"},       {"meters", "m"},     {"metre", "m"},     {"metres", "m"},         {"mps", "m/s"},
    {"kmh", "km/h"},      {"kph", "km/h"},     {"knot", "kn"},     {"knots", "kn"},         {"kt", "kn"},
    {"kts", "kn"},        {"dps", "deg/s"},    {"dph", "deg/h"},   {"feet", "ft"},          {"foot", "ft"},
    {"mil_nato", "mil"},  {"mbar", "hPa"},     {"percent", "%"},   {"arcminute", "arcmin"}, {"arcsecond", "arcsec"},
    {"rtHz", "sqrt(Hz)"}, {"rthr", "sqrt(h)"}, {"rth", "sqrt(h)"}, {"mps2", "m/s^2"},
};

constexpr std::pair<char, long double> prefixes[] = {{'n', 1e-9L}, {'u', 1e-6L}, {'m', 1e-3L}, {'c', 1e-2L},
                                                     {'h', 1e2L},  {'k', 1e3L},  {'M', 1e6L},  {'G', 1e9L}};

const KnownUnit* find_named(std::string_view name) {
  const auto* found = std::ranges::find(named_units, name, &KnownUnit::name);
  return found == std::end(named_units) ? nullptr : found;
}

std::optional<Measure> find_measure(std::string_view name) {
  if (const KnownUnit* unit = find_named(name)) return unit->measure;
  const KnownUnit* unit = name.empty() ? nullptr : find_named(name.substr(1));
  for (const auto& [prefix, scale] : prefixes)
    if (unit && prefix == name[0] && unit->prefixes.find(prefix) != name.npos)
      return Measure{unit->measure.scale * scale, unit->measure.dimension};
  return std::nullopt;
}

using internal::base::in_quotes;
using internal::base::is_digit;

bool is_name_character(char c) {
  return (internal::base::is_word(c, "%_") && !is_digit(c)) || static_cast<unsigned char>(c) >= 0x80;
}

/// What is wrong with a unit: an unknown name and where it stands, or `why`, to be read after the unit's own text.
struct Refusal {
  std::string why;
  std::string_view name = {};
  std::size_t at = 0;
};

/// unit    = factor { ("*" | "." | "/") factor }
/// factor  = primary [ "^" integer ]
/// primary = "sqrt(" unit ")" | "(" unit ")" | name
struct UnitParser {
  std::string_view text;
  std::size_t at = 0;

  /// Throws a Refusal.
  Measure parse() {
    if (text.size() > longest) throw Refusal{"is too long"};
    const Measure result = unit();
    if (at < text.size()) throw unexpected();
    if (!std::isnormal(static_cast<double>(result.scale))) throw Refusal{"is out of range"};
    return result;
  }

  static constexpr std::size_t longest = 80;
  static constexpr int largest_exponent = 12;

  char peek(std::size_t ahead = 0) const { return at + ahead < text.size() ? text[at + ahead] : '\0'; }

  Refusal unexpected() const {
    if (at >= text.size()) return {"ends where a unit is expected"};
    const std::string found = "has an unexpected " + in_quotes(text.substr(at, 1));
    if (is_digit(peek()) && at > 0) return {found + "; a power is written '^" + peek() + "'"};
    return {found + (peek() == ' ' ? "; write '*' for a product" : "")};
  }

  Measure unit() {
    Measure result = factor();
    while (peek() == '*' || peek() == '.' || peek() == '/') {
      const bool divide = text[at++] == '/';
      const Measure next = factor();
      result = divide ? Measure{result.scale / next.scale, result.dimension / next.dimension}
                      : Measure{result.scale * next.scale, result.dimension * next.dimension};
      check_exponents(result);
    }
    return result;
  }

  Measure factor() {
    const Measure base = primary();
    if (peek() != '^') return base;
    ++at;
    int exponent = 0;
    const char* first = text.data() + at;
    const auto [last, status] = std::from_chars(first, text.data() + text.size(), exponent);
    at += static_cast<std::size_t>(last - first);
    if (status != std::errc() || (peek() == '.' && is_digit(peek(1))))
      throw Refusal{"has a power that is not a whole number; a root is written sqrt(...)"};
    if (std::abs(exponent) > largest_exponent) throw Refusal{"has an exponent out of range"};
    Measure result{1.0L, base.dimension};
    for (int i = 0; i < std::abs(exponent); ++i) result.scale *= base.scale;
    if (exponent < 0) result.scale = 1.0L / result.scale;
    for (int& doubled : result.dimension.doubled) doubled *= exponent;
    check_exponents(result);
    return result;
  }

  static void check_exponents(const Measure& measure) {
    for (const int doubled : measure.dimension.doubled)
      if (std::abs(doubled) > 2 * largest_exponent) throw Refusal{"has an exponent out of range"};
  }

  Measure primary() {
    if (peek() == '(') return parenthesis();
    const std::size_t start = at;
    while (is_name_character(peek())) ++at;
    if (at == start && peek() == '1') ++at;
    const std::string_view name = text.substr(start, at - start);
    if (name.empty()) throw unexpected();
    if (name == "sqrt" && peek() == '(') return root(parenthesis());
    if (const std::optional<Measure> found = find_measure(name)) return *found;
    throw Refusal{"", name, start};
  }

  Measure parenthesis() {
    ++at;
    const Measure inner = unit();
    if (peek() != ')') throw at < text.size() ? unexpected() : Refusal{"lacks a ')'"};
    ++at;
    return inner;
  }

  static Measure root(const Measure& square) {
    Measure result{std::sqrt(square.scale), square.dimension};
    for (int& doubled : result.dimension.doubled) {
      if (doubled % 2 != 0) throw Refusal{"has a root of a root"};
      doubled /= 2;
    }
    return result;
  }
};

std::string meant_name(std::string_view name) {
  for (const auto& [other, ours] : other_spellings)
    if (other == name) return std::string(ours);
  std::vector<std::string> names = internal::base::names_of(named_units);
  for (const KnownUnit& unit : named_units)
    for (const char prefix : unit.prefixes) names.push_back(prefix + std::string(unit.name));
  return closest(name, names);
}

/// The text with every unknown name replaced by the one that was probably meant; "" if that makes no unit.
std::string meant_unit(std::string text) {
  for (int replaced = 0; replaced < 4; ++replaced) {
    try {
      UnitParser{text}.parse();
      return text;
    } catch (const Refusal& refusal) {
      const std::string meant = refusal.name.empty() ? "" : meant_name(refusal.name);
      if (meant.empty()) return {};
      text.replace(refusal.at, refusal.name.size(), meant);
    }
  }
  return {};
}

std::string unknown_message(std::string_view text, std::string_view name) {
  const std::string unknown = "unknown unit " + in_quotes(text);
  if (name.ends_with("C") && (name == "degC" || name.starts_with("\xC2\xB0")))
    return unknown + "; a temperature is given in kelvin, 'K'";
  const std::string meant = meant_unit(std::string(text));
  if (!meant.empty()) return unknown + "; did you mean " + in_quotes(meant) + "?";
  return unknown + (name == text ? "" : " (" + in_quotes(name) + ")");
}

Parsed<Measure> read_measure(std::string_view text) {
  using Answer = Parsed<Measure>;
  if (text.empty()) return Answer::failure("empty unit; a number without a unit is '1'");
  try {
    return UnitParser{text}.parse();
  } catch (const Refusal& refusal) {
    return Answer::failure(refusal.name.empty() ? "unit " + in_quotes(text) + " " + refusal.why
                                                : unknown_message(text, refusal.name));
  }
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// A number and the unit behind it, "" where there is none.
template <class Number>
struct Written {
  Number value = 0;
  bool fits = true;  // into a Number
  std::string_view unit;
};

/// Nothing if the text does not begin with a number.
template <class Number>
std::optional<Written<Number>> split(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const std::string_view digits = text.substr(text.starts_with('-') ? 1 : 0);
  const std::size_t point = digits.starts_with('.') ? 1 : 0;
  if (digits.size() <= point || !is_digit(digits[point])) return std::nullopt;
  Written<Number> written;
  const char* end = text.data() + text.size();
  const auto [last, status] = std::from_chars(text.data(), end, written.value);
  written.fits = status == std::errc();
  written.unit = trimmed(std::string_view(last, static_cast<std::size_t>(end - last)));
  return written;
}

}  // namespace

Parsed<Unit> parse_unit(std::string_view text) {
  const Parsed<Measure> measure = read_measure(text);
  if (!measure) return Parsed<Unit>::failure(measure.error());
  return Unit{static_cast<double>(measure->scale), measure->dimension};
}

Parsed<Quantity> parse_quantity(std::string_view text) {
  using Answer = Parsed<Quantity>;
  text = trimmed(text);
  if (text.empty()) return Answer::failure("empty text; expected a number with a unit, such as '0.2 deg/h'");
  const auto written = split<double>(text);
  const std::string quoted = in_quotes(text);
  if (!written) return Answer::failure(quoted + " does not begin with a number; expected something like '0.2 deg/h'");
  if (!written->fits) return Answer::failure("the number of " + quoted + " is out of range");
  if (written->unit.empty()) return Quantity{written->value, {}};
  if (written->unit.starts_with(',')) return Answer::failure("the decimal point of " + quoted + " is a comma");
  const Parsed<Measure> measure = read_measure(written->unit);
  if (!measure) return Answer::failure(measure.error());
  const auto si = static_cast<double>(static_cast<long double>(written->value) * measure->scale);
  if (!std::isfinite(si)) return Answer::failure(quoted + " is out of range");
  return Quantity{si, measure->dimension};
}

Parsed<std::int64_t> parse_time(std::string_view text) {
  using Answer = Parsed<std::int64_t>;
  text = trimmed(text);
  const auto written = split<long double>(text);
  const std::string quoted = in_quotes(text);
  if (!written) return Answer::failure(quoted + " does not begin with a number; expected something like '120 s'");
  if (written->unit.empty())
    return Answer::failure(quoted + " has no unit; write " + in_quotes(std::string(text) + " s"));
  const std::optional<Measure> unit = find_measure(written->unit);
  if (!unit || unit->dimension != dimension(0, 1))
    return Answer::failure("unit " + in_quotes(written->unit) + " is not a time; use ns, us, ms, s, min, h or day");
  const long double nanoseconds = written->value * std::round(unit->scale * 1e9L);
  if (!written->fits || !(std::abs(nanoseconds) <= static_cast<long double>(internal::base::farthest_time)))
    return Answer::failure("the time " + quoted + " is beyond " + internal::base::farthest_text);
  return static_cast<std::int64_t>(std::llround(nanoseconds));
}

// ---- texts of dimensions

namespace {

/// In the order of printing.
constexpr std::pair<Dimension::Base, std::string_view> base_units[] = {
    {Dimension::mass, "kg"},       {Dimension::length, "m"},  {Dimension::angle, "rad"},
    {Dimension::temperature, "K"}, {Dimension::current, "A"}, {Dimension::time, "s"}};

/// "m^2" for 4, "m*sqrt(m)" for 3; the factors joined by the separator.
std::string power_text(std::string_view base, int doubled, char separator) {
  std::string text(doubled / 2 > 0 ? base : "");
  if (doubled / 2 > 1) text += "^" + std::to_string(doubled / 2);
  if (doubled % 2 == 0) return text;
  if (!text.empty()) text += separator;
  return text + "sqrt(" + std::string(base) + ")";
}

constexpr std::pair<std::string_view, std::string_view> named_dimensions[] = {
    {"m/s^3", "a jerk"},
    {"rad/s", "an angular rate"},
    {"rad/s^2", "an angular acceleration"},
    {"m^2", "an area or squared length"},
    {"rad^2", "a squared angle"},
    {"1/m", "a curvature"},
    {"m/sqrt(s)", "a position random walk"},
    {"m/s/sqrt(s)", "a velocity random walk"},
    {"m/s^2/sqrt(s)", "an acceleration random walk"},
    {"rad/sqrt(s)", "an angle random walk"},
    {"rad/s/sqrt(s)", "an angular rate random walk"},
};

}  // namespace

std::string si_unit(const Dimension& dimension) {
  for (const char* derived : {"N", "Pa", "T", "V"})
    if (find_named(derived)->measure.dimension == dimension) return derived;
  std::string above, below;
  for (const auto& [base, unit] : base_units) {
    const int doubled = dimension.doubled[base];
    if (doubled > 0) above += (above.empty() ? "" : "*") + power_text(unit, doubled, '*');
    if (doubled < 0) below += "/" + power_text(unit, -doubled, '/');
  }
  return (above.empty() ? "1" : above) + below;
}

std::string dimension_name(const Dimension& dimension) {
  if (dimension.is_dimensionless()) return "a plain number";
  const std::string unit = si_unit(dimension);
  for (const KnownUnit& known : named_units)
    if (known.measure.dimension == dimension && !known.quantity.empty())
      return std::string(known.quantity) + " (" + unit + ")";
  for (const auto& [of, name] : named_dimensions)
    if (of == unit) return std::string(name) + " (" + unit + ")";
  return "a quantity in " + unit;
}

}  // namespace binnacle
