// SPDX-License-Identifier: Apache-2.0
// Units: the table, the grammar, and the texts that go with a dimension.
#include "binnacle/unit.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <vector>

#include "base/text.hpp"
#include "binnacle/diagnostic.hpp"

namespace binnacle {

Dimension operator*(const Dimension& a, const Dimension& b) {
  Dimension result;
  for (std::size_t i = 0; i < Dimension::base_count; ++i) result.doubled[i] = a.doubled[i] + b.doubled[i];
  return result;
}

Dimension operator/(const Dimension& a, const Dimension& b) {
  Dimension result;
  for (std::size_t i = 0; i < Dimension::base_count; ++i) result.doubled[i] = a.doubled[i] - b.doubled[i];
  return result;
}

namespace {

// Scales are carried in long double, so that the double which leaves here is the nearest one: "300 ms" is
// 0.3.
struct Measure {
  long double scale = 1.0L;
  Dimension dimension;
};

struct NamedUnit {
  std::string_view name;
  Measure measure;
  std::string_view prefixes;
};

constexpr Dimension dimension(int m, int s, int rad = 0, int kg = 0, int kelvin = 0, int ampere = 0) {
  return {{2 * m, 2 * s, 2 * rad, 2 * kg, 2 * kelvin, 2 * ampere}};
}

constexpr long double pi = std::numbers::pi_v<long double>;
constexpr long double standard_gravity = 9.80665L;  // m/s^2, 3rd CGPM (1901)

constexpr NamedUnit named_units[] = {
    {"1", {1.0L, {}}, ""},
    {"%", {1e-2L, {}}, ""},
    {"ppm", {1e-6L, {}}, ""},
    {"ppb", {1e-9L, {}}, ""},
    {"m", {1.0L, dimension(1, 0)}, "numck"},
    {"s", {1.0L, dimension(0, 1)}, "num"},
    {"min", {60.0L, dimension(0, 1)}, ""},
    {"h", {3600.0L, dimension(0, 1)}, ""},
    {"day", {86400.0L, dimension(0, 1)}, ""},
    {"Hz", {1.0L, dimension(0, -1)}, "mkMG"},
    {"rad", {1.0L, dimension(0, 0, 1)}, "num"},
    {"deg", {pi / 180.0L, dimension(0, 0, 1)}, "um"},
    {"arcmin", {pi / 10800.0L, dimension(0, 0, 1)}, ""},
    {"arcsec", {pi / 648000.0L, dimension(0, 0, 1)}, "um"},
    {"mil", {pi / 3200.0L, dimension(0, 0, 1)}, ""},
    {"gon", {pi / 200.0L, dimension(0, 0, 1)}, "m"},
    {"g", {standard_gravity, dimension(1, -2)}, "num"},
    {"Gal", {1e-2L, dimension(1, -2)}, "um"},
    {"kn", {1852.0L / 3600.0L, dimension(1, -1)}, ""},
    {"nmi", {1852.0L, dimension(1, 0)}, ""},
    {"ft", {0.3048L, dimension(1, 0)}, ""},
    {"kg", {1.0L, dimension(0, 0, 0, 1)}, ""},
    {"K", {1.0L, dimension(0, 0, 0, 0, 1)}, "um"},
    {"A", {1.0L, dimension(0, 0, 0, 0, 0, 1)}, "numk"},
    {"N", {1.0L, dimension(1, -2, 0, 1)}, "umk"},
    {"Pa", {1.0L, dimension(-1, -2, 0, 1)}, "mhkM"},
    {"T", {1.0L, dimension(0, -2, 0, 1, 0, -1)}, "num"},
    {"V", {1.0L, dimension(2, -3, 0, 1, 0, -1)}, "numk"},
};

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
    {"rtHz", "sqrt(Hz)"}, {"rthr", "sqrt(h)"}, {"rth", "sqrt(h)"},
};

long double prefix_scale(char prefix) {
  switch (prefix) {
    case 'n': return 1e-9L;
    case 'u': return 1e-6L;
    case 'm': return 1e-3L;
    case 'c': return 1e-2L;
    case 'h': return 1e2L;
    case 'k': return 1e3L;
    case 'M': return 1e6L;
    default: return 1e9L;  // G
  }
}

const NamedUnit* find_named(std::string_view name) {
  const auto* end = std::end(named_units);
  const auto* found = std::find_if(std::begin(named_units), end, [&](const NamedUnit& u) { return u.name == name; });
  return found == end ? nullptr : found;
}

std::optional<Measure> find_measure(std::string_view name) {
  if (const NamedUnit* unit = find_named(name)) return unit->measure;
  if (name.size() < 2) return std::nullopt;
  const NamedUnit* unit = find_named(name.substr(1));
  if (!unit || unit->prefixes.find(name[0]) == std::string_view::npos) return std::nullopt;
  return Measure{unit->measure.scale * prefix_scale(name[0]), unit->measure.dimension};
}

std::vector<std::string> every_name() {
  std::vector<std::string> names;
  for (const NamedUnit& unit : named_units) names.emplace_back(unit.name);
  for (const NamedUnit& unit : named_units) {
    for (const char prefix : unit.prefixes) names.push_back(prefix + std::string(unit.name));
  }
  return names;
}

using base::in_quotes;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '%' || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}

struct UnknownName {
  std::size_t at;
  std::string_view name;
};

/// unit    = factor { ("*" | "." | "/") factor }
/// factor  = primary [ "^" integer ]
/// primary = "sqrt(" unit ")" | "(" unit ")" | name
class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : text_(text) {}

  std::optional<Measure> parse() {
    if (text_.size() > longest) return fail("is too long");
    std::optional<Measure> result = unit();
    if (result && at_ < text_.size()) return fail(unexpected());
    if (result && !std::isnormal(static_cast<double>(result->scale))) return fail("is out of range");
    return result;
  }

  /// Without the unit's own text: "has an unexpected '2' ...".
  const std::string& error() const { return error_; }
  const std::optional<UnknownName>& unknown() const { return unknown_; }

 private:
  static constexpr std::size_t longest = 80;
  static constexpr int largest_exponent = 12;

  std::optional<Measure> fail(std::string message) {
    if (error_.empty()) error_ = std::move(message);
    return std::nullopt;
  }

  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }

  std::string unexpected() const {
    if (at_ >= text_.size()) return "ends where a unit is expected";
    const std::string found = "has an unexpected " + in_quotes(text_.substr(at_, 1));
    if (is_digit(peek()) && at_ > 0) return found + "; a power is written '^" + peek() + "'";
    if (peek() == ' ') return found + "; write '*' for a product";
    return found;
  }

  std::optional<Measure> unit() {
    std::optional<Measure> result = factor();
    while (result && (peek() == '*' || peek() == '.' || peek() == '/')) {
      const bool divide = text_[at_++] == '/';
      const std::optional<Measure> next = factor();
      if (!next) return std::nullopt;
      result = divide ? Measure{result->scale / next->scale, result->dimension / next->dimension}
                      : Measure{result->scale * next->scale, result->dimension * next->dimension};
      if (!in_range(*result)) return fail("has an exponent out of range");
    }
    return result;
  }

  std::optional<Measure> factor() {
    const std::optional<Measure> base = primary();
    if (!base || peek() != '^') return base;
    ++at_;
    int exponent = 0;
    const char* first = text_.data() + at_;
    const auto [last, status] = std::from_chars(first, text_.data() + text_.size(), exponent);
    if (status != std::errc()) return fail("has a power that is no whole number; a root is written sqrt(...)");
    at_ += static_cast<std::size_t>(last - first);
    if (peek() == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1])) {
      return fail("has a power that is no whole number; a root is written sqrt(...)");
    }
    return power(*base, exponent);
  }

  std::optional<Measure> power(const Measure& base, int exponent) {
    if (std::abs(exponent) > largest_exponent) return fail("has an exponent out of range");
    Measure result;
    for (int i = 0; i < std::abs(exponent); ++i) result.scale *= base.scale;
    if (exponent < 0) result.scale = 1.0L / result.scale;
    result.dimension = base.dimension;
    for (int& doubled : result.dimension.doubled) doubled *= exponent;
    if (!in_range(result)) return fail("has an exponent out of range");
    return result;
  }

  static bool in_range(const Measure& measure) {
    return std::all_of(measure.dimension.doubled.begin(), measure.dimension.doubled.end(),
                       [](int doubled) { return std::abs(doubled) <= 2 * largest_exponent; });
  }

  std::optional<Measure> primary() {
    if (peek() == '(') return parenthesis();
    const std::size_t start = at_;
    while (is_name_character(peek())) ++at_;
    if (at_ == start && peek() == '1') ++at_;
    const std::string_view name = text_.substr(start, at_ - start);
    if (name.empty()) return fail(unexpected());
    if (name == "sqrt" && peek() == '(') return root(parenthesis());
    if (const std::optional<Measure> found = find_measure(name)) return found;
    if (!unknown_) unknown_ = UnknownName{start, name};
    return fail("is unknown");
  }

  std::optional<Measure> parenthesis() {
    ++at_;
    const std::optional<Measure> inner = unit();
    if (!inner) return std::nullopt;
    if (peek() != ')') return fail(at_ < text_.size() ? unexpected() : "lacks a ')'");
    ++at_;
    return inner;
  }

  std::optional<Measure> root(const std::optional<Measure>& square) {
    if (!square) return std::nullopt;
    Measure result{std::sqrt(square->scale), square->dimension};
    for (int& doubled : result.dimension.doubled) {
      if (doubled % 2 != 0) return fail("has a root of a root");
      doubled /= 2;
    }
    return result;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::string error_;
  std::optional<UnknownName> unknown_;
};

std::string meant_name(std::string_view name) {
  for (const auto& [other, ours] : other_spellings) {
    if (other == name) return std::string(ours);
  }
  return closest(name, every_name());
}

/// The text with every unknown name replaced by the one that was probably meant; "" if that makes no unit.
std::string meant_unit(std::string text) {
  for (int replaced = 0; replaced < 4; ++replaced) {
    UnitParser parser(text);
    if (parser.parse()) return text;
    if (!parser.unknown()) return {};
    const std::string meant = meant_name(parser.unknown()->name);
    if (meant.empty()) return {};
    text.replace(parser.unknown()->at, parser.unknown()->name.size(), meant);
  }
  return {};
}

std::string unknown_message(std::string_view text, std::string_view name) {
  if (name == "degC" || name ==
                            "\xC2\xB0"
                            "C") {
    return "unknown unit " + in_quotes(text) + "; a temperature is given in kelvin, 'K'";
  }
  const std::string meant = meant_unit(std::string(text));
  const std::string where = name == text ? "" : " (" + in_quotes(name) + ")";
  if (meant.empty()) return "unknown unit " + in_quotes(text) + where;
  return "unknown unit " + in_quotes(text) + "; did you mean " + in_quotes(meant) + "?";
}

Parsed<Measure> read_measure(std::string_view text) {
  using Result = Parsed<Measure>;
  if (text.empty()) return Result::failure("empty unit; a number without a unit is '1'");
  UnitParser parser(text);
  if (const std::optional<Measure> measure = parser.parse()) return *measure;
  if (parser.unknown()) return Result::failure(unknown_message(text, parser.unknown()->name));
  return Result::failure("unit " + in_quotes(text) + " " + parser.error());
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// Where the number begins, without a plus sign; nothing if there is none.
std::optional<std::string_view> at_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const std::size_t digits = text.starts_with('-') ? 1 : 0;
  const auto digit_at = [&](std::size_t i) { return i < text.size() && is_digit(text[i]); };
  if (digit_at(digits) || (digits < text.size() && text[digits] == '.' && digit_at(digits + 1))) return text;
  return std::nullopt;
}

std::string no_number(std::string_view text) {
  return text.empty() ? "empty text; expected a number with a unit, such as '0.2 deg/h'"
                      : in_quotes(text) + " does not begin with a number; expected something like '0.2 deg/h'";
}

}  // namespace

Parsed<Unit> read_unit(std::string_view text) {
  const Parsed<Measure> measure = read_measure(text);
  if (!measure) return Parsed<Unit>::failure(measure.error());
  return Unit{static_cast<double>(measure->scale), measure->dimension};
}

std::optional<Unit> parse_unit(std::string_view text) {
  const Parsed<Unit> unit = read_unit(text);
  return unit ? std::optional<Unit>(*unit) : std::nullopt;
}

Parsed<Quantity> parse_quantity(std::string_view text) {
  using Result = Parsed<Quantity>;
  text = trimmed(text);
  const std::optional<std::string_view> number = at_number(text);
  if (!number) return Result::failure(no_number(text));
  double value = 0.0;
  const char* end = number->data() + number->size();
  const auto [last, status] = std::from_chars(number->data(), end, value);
  if (status != std::errc()) return Result::failure("the number of " + in_quotes(text) + " is out of range");
  const std::string_view unit_text = trimmed(std::string_view(last, static_cast<std::size_t>(end - last)));
  if (unit_text.empty()) return Quantity{value, {}};
  if (unit_text.starts_with(',')) return Result::failure("the decimal point of " + in_quotes(text) + " is a comma");
  const Parsed<Measure> measure = read_measure(unit_text);
  if (!measure) return Result::failure(measure.error());
  const auto si = static_cast<double>(static_cast<long double>(value) * measure->scale);
  if (!std::isfinite(si)) return Result::failure(in_quotes(text) + " is out of range");
  return Quantity{si, measure->dimension};
}

// Texts of dimensions
// ------------------------------------------------------------------------------------------

namespace {

constexpr std::string_view base_names[] = {"m", "s", "rad", "kg", "K", "A"};
constexpr std::size_t print_order[] = {Dimension::mass,        Dimension::length,  Dimension::angle,
                                       Dimension::temperature, Dimension::current, Dimension::time};

/// "m^2" for 4, "m*sqrt(m)" for 3; the factors joined by the separator.
std::string power_text(std::string_view base, int doubled, char separator) {
  std::string text;
  if (doubled / 2 == 1) text = base;
  if (doubled / 2 > 1) text = std::string(base) + "^" + std::to_string(doubled / 2);
  if (doubled % 2 == 0) return text;
  if (!text.empty()) text += separator;
  return text + "sqrt(" + std::string(base) + ")";
}

struct NamedDimension {
  std::string_view unit;
  std::string_view name;
};

constexpr NamedDimension named_dimensions[] = {
    {"m", "a length"},
    {"s", "a time"},
    {"rad", "an angle"},
    {"m/s", "a velocity"},
    {"m/s^2", "an acceleration"},
    {"m/s^3", "a jerk"},
    {"rad/s", "an angular rate"},
    {"rad/s^2", "an angular acceleration"},
    {"1/s", "a frequency or rate"},
    {"m^2", "an area or squared length"},
    {"rad^2", "a squared angle"},
    {"1/m", "a curvature"},
    {"m/sqrt(s)", "a position random walk"},
    {"m/s/sqrt(s)", "a velocity random walk"},
    {"m/s^2/sqrt(s)", "an acceleration random walk"},
    {"rad/sqrt(s)", "an angle random walk"},
    {"rad/s/sqrt(s)", "an angular rate random walk"},
    {"kg", "a mass"},
    {"K", "a temperature"},
    {"A", "a current"},
    {"N", "a force"},
    {"Pa", "a pressure"},
    {"T", "a magnetic flux density"},
    {"V", "a voltage"},
};

constexpr std::string_view derived_units[] = {"N", "Pa", "T", "V"};

}  // namespace

std::string si_unit(const Dimension& dimension) {
  for (const std::string_view name : derived_units) {
    if (find_named(name)->measure.dimension == dimension) return std::string(name);
  }
  std::string above;
  std::string below;
  for (const std::size_t base : print_order) {
    const int doubled = dimension.doubled[base];
    if (doubled > 0) above += (above.empty() ? "" : "*") + power_text(base_names[base], doubled, '*');
    if (doubled < 0) below += "/" + power_text(base_names[base], -doubled, '/');
  }
  return (above.empty() ? "1" : above) + below;
}

std::string dimension_name(const Dimension& dimension) {
  if (dimension.is_dimensionless()) return "a plain number";
  const std::string unit = si_unit(dimension);
  for (const NamedDimension& named : named_dimensions) {
    if (named.unit == unit) return std::string(named.name) + " (" + unit + ")";
  }
  return "a quantity in " + unit;
}

// Time
// ---------------------------------------------------------------------------------------------------------

namespace {

__extension__ typedef __int128 Wide;

constexpr int most_digits = 22;  // 10^22 days in nanoseconds fit into 128 bits

struct TimeUnit {
  std::string_view name;
  std::int64_t nanoseconds;
};

constexpr TimeUnit time_units[] = {
    {"ns", 1},
    {"us", 1'000},
    {"ms", 1'000'000},
    {"s", 1'000'000'000},
    {"min", 60'000'000'000},
    {"h", 3'600'000'000'000},
    {"day", 86'400'000'000'000},
};

/// digits * 10^exponent, exactly.
struct Decimal {
  Wide digits = 0;
  int exponent = 0;
  std::string_view rest;
};

std::optional<Decimal> read_decimal(std::string_view text) {
  Decimal decimal;
  const bool negative = text.starts_with('-');
  std::size_t at = negative ? 1 : 0;
  bool after_point = false;
  int significant = 0;
  for (; at < text.size() && (is_digit(text[at]) || (text[at] == '.' && !after_point)); ++at) {
    if (text[at] == '.') {
      after_point = true;
      continue;
    }
    decimal.digits = decimal.digits * 10 + (text[at] - '0');
    if (decimal.digits > 0 && ++significant > most_digits) return std::nullopt;
    if (after_point) --decimal.exponent;
  }
  if (negative) decimal.digits = -decimal.digits;
  if (at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    const char* first = text.data() + at + 1;
    const char* end = text.data() + text.size();
    if (first != end && *first == '+') ++first;
    int exponent = 0;
    const auto [last, status] = std::from_chars(first, end, exponent);
    if (status != std::errc() || std::abs(exponent) > 100) return std::nullopt;
    decimal.exponent += exponent;
    at = static_cast<std::size_t>(last - text.data());
  }
  decimal.rest = text.substr(at);
  return decimal;
}

/// value * 10^exponent to the nearest, halves away from zero; nothing beyond int64.
std::optional<std::int64_t> scaled(Wide value, int exponent) {
  constexpr Wide largest = std::numeric_limits<std::int64_t>::max();
  for (; exponent > 0 && value != 0; --exponent) {
    value *= 10;
    if (value > largest || value < -largest) return std::nullopt;
  }
  Wide divisor = 1;
  for (; exponent < 0; ++exponent) {
    divisor *= 10;
    if (divisor > (value < 0 ? -value : value) * 2) return 0;
  }
  const Wide half = divisor / 2;
  const Wide rounded = (value < 0 ? value - half : value + half) / divisor;
  if (rounded > largest || rounded < -largest) return std::nullopt;
  return static_cast<std::int64_t>(rounded);
}

}  // namespace

Parsed<std::int64_t> parse_time(std::string_view text) {
  using Result = Parsed<std::int64_t>;
  text = trimmed(text);
  const std::optional<std::string_view> number = at_number(text);
  if (!number)
    return Result::failure(in_quotes(text) + " does not begin with a number; expected something like '120 s'");
  const std::optional<Decimal> decimal = read_decimal(*number);
  if (!decimal) return Result::failure("the number of " + in_quotes(text) + " has too many digits");
  const std::string_view unit = trimmed(decimal->rest);
  if (unit.empty())
    return Result::failure(in_quotes(text) + " has no unit; write " + in_quotes(std::string(text) + " s"));
  const auto* known =
      std::find_if(std::begin(time_units), std::end(time_units), [&](const TimeUnit& u) { return u.name == unit; });
  if (known == std::end(time_units)) {
    return Result::failure("unit " + in_quotes(unit) + " is no time; use ns, us, ms, s, min, h or day");
  }
  const std::optional<std::int64_t> nanoseconds = scaled(decimal->digits * known->nanoseconds, decimal->exponent);
  if (!nanoseconds) return Result::failure("the time " + in_quotes(text) + " is out of range");
  return *nanoseconds;
}

}  // namespace binnacle
