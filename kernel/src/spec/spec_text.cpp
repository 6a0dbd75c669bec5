// SPDX-License-Identifier: Apache-2.0
// What a spec asks for, in words.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/text.hpp"
#include "binnacle/catalog.hpp"
#include "spec/check.hpp"

namespace binnacle::internal::spec {

std::optional<std::string> port_of_unit(std::string_view unit) {
  if (!unit.starts_with('@')) return std::nullopt;
  const std::string_view port = unit.substr(1, unit.find_first_of("*/^.", 1) - 1);
  return std::string(port);
}

std::optional<PortMeasure> measure_of(const PortUnits& ports, std::string_view port) {
  const auto found = ports.find(port);
  return found == ports.end() ? std::nullopt : std::optional(found->second);
}

WantedUnit wanted_unit(const ParameterSpec& spec, const PortUnits& ports) {
  if (spec.unit == "*") return {std::nullopt, "any unit"};
  std::string text = spec.unit.empty() ? "1" : spec.unit;
  if (const std::optional<std::string> port = port_of_unit(spec.unit)) {
    const std::optional<PortMeasure> measure = measure_of(ports, *port);
    if (!measure) return {std::nullopt, "unit of " + spec.unit.substr(1)};
    text = "(" + si_unit(measure->dimension) + ")" + spec.unit.substr(1 + port->size());
  }
  const Parsed<Unit> unit = parse_unit(text);
  return unit ? WantedUnit{unit->dimension, si_unit(unit->dimension)} : WantedUnit{std::nullopt, spec.unit};
}

bool takes_quantities(ParameterType type) {
  return type == ParameterType::number || type == ParameterType::vector || type == ParameterType::matrix ||
         type == ParameterType::time;
}

std::string number_text(double value, int digits) {
  char text[40];
  const auto [end, status] = std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits);
  return status == std::errc() ? std::string(text, end) : "?";
}

std::string range_text(const ParameterSpec& spec) {
  std::string text;
  if (std::isfinite(spec.minimum)) text = (spec.minimum_excluded ? "> " : ">= ") + number_text(spec.minimum, 6);
  if (!std::isfinite(spec.maximum)) return text;
  return joined(text, (spec.maximum_excluded ? "< " : "<= ") + number_text(spec.maximum, 6));
}

bool in_range(const ParameterSpec& spec, double value) {
  const bool above = spec.minimum_excluded ? value > spec.minimum : value >= spec.minimum;
  const bool below = spec.maximum_excluded ? value < spec.maximum : value <= spec.maximum;
  return above && below;
}

std::string joined(const std::string& a, const std::string& b) { return a.empty() || b.empty() ? a + b : a + ", " + b; }

std::string unit_and_range(const ParameterSpec& spec, const PortUnits& ports) {
  const std::string unit = wanted_unit(spec, ports).text;
  return joined(unit == "1" ? "" : unit, range_text(spec));
}

namespace {

std::string values_text(int count) { return std::to_string(count) + (count == 1 ? " value" : " values"); }

std::string shape_text(const ParameterSpec& spec, const PortUnits& ports) {
  const bool is_matrix = spec.type == ParameterType::matrix;
  if (!spec.size_of_port.empty()) {
    const std::optional<PortMeasure> measure = measure_of(ports, spec.size_of_port);
    if (!measure) return (is_matrix ? "square, as large as " : "as many as ") + spec.size_of_port;
    const std::string n = std::to_string(measure->dof);
    return is_matrix ? n + " by " + n : values_text(measure->dof);
  }
  if (!is_matrix) return spec.size == ParameterSpec::any_size ? "list" : values_text(spec.size);
  const auto side = [](int n) { return n == ParameterSpec::any_size ? std::string("any") : std::to_string(n); };
  const bool is_free = spec.size == ParameterSpec::any_size && spec.cols == ParameterSpec::any_size;
  return is_free ? "matrix" : side(spec.size) + " by " + side(spec.cols);
}

/// What a type is called: short, and in "must be …".
struct Words {
  std::string as_noun, expected;
};

Words words_of(ParameterType type) {
  switch (type) {
    case ParameterType::number: return {"", "a number or text with a unit"};
    case ParameterType::integer: return {"integer", "an integer"};
    case ParameterType::boolean: return {"true or false", "true or false"};
    case ParameterType::text: return {"text", "a text"};
    case ParameterType::choice: return {"one of ", "one of "};
    case ParameterType::path: return {"file or folder", "the name of a file or folder"};
    case ParameterType::vector: return {"", "a list of numbers or texts with a unit"};
    case ParameterType::matrix: return {"", "a list of rows, each a list"};
    case ParameterType::time: return {"s", "a time"};
    case ParameterType::list: return {"list", "a list"};
    case ParameterType::map: return {"object with free keys", "an object"};
    case ParameterType::object: return {"object", "an object"};
  }
  return {};
}

}  // namespace

std::string describe_short(const ParameterSpec& spec, const PortUnits& ports) {
  switch (spec.type) {
    case ParameterType::number: {
      const std::string text = unit_and_range(spec, ports);
      return text.empty() ? "plain number" : text;
    }
    case ParameterType::choice: return words_of(spec.type).as_noun + base::quoted_list(spec.choices);
    case ParameterType::vector:
    case ParameterType::matrix: return joined(shape_text(spec, ports), unit_and_range(spec, ports));
    default: return joined(words_of(spec.type).as_noun, range_text(spec));
  }
}

namespace {

/// By SI unit.
constexpr std::pair<std::string_view, std::string_view> examples[] = {
    {"s", "1 h"},
    {"m", "0.5 m"},
    {"rad", "2 deg"},
    {"m/s", "0.1 m/s"},
    {"m/s^2", "500 ug"},
    {"rad/s", "0.2 deg/h"},
    {"1/s", "100 Hz"},
    {"rad/sqrt(s)", "0.05 deg/sqrt(h)"},
    {"m/s/sqrt(s)", "50 ug/sqrt(Hz)"},
    {"m/s^2/sqrt(s)", "10 ug/sqrt(h)"},
    {"rad/s/sqrt(s)", "1 deg/h/sqrt(h)"},
};

/// A number inside the range: the default's place, as it were.
double number_in_range(const ParameterSpec& spec) {
  if (std::isfinite(spec.minimum) && std::isfinite(spec.maximum)) return 0.5 * (spec.minimum + spec.maximum);
  if (std::isfinite(spec.minimum)) return in_range(spec, 1) ? 1 : spec.minimum + 1;
  if (std::isfinite(spec.maximum)) return in_range(spec, 1) ? 1 : spec.maximum - 1;
  return 1;
}

/// The quantity without quotes.
std::string example_quantity(const ParameterSpec& spec, const PortUnits& ports) {
  if (spec.type == ParameterType::time && in_range(spec, 1)) return "1 s";
  const WantedUnit unit = wanted_unit(spec, ports);
  if (!unit.dimension) return number_text(number_in_range(spec));
  for (const auto& [of, text] : examples)
    if (of == unit.text && in_range(spec, parse_quantity(text)->value)) return std::string(text);
  return number_text(number_in_range(spec)) + (unit.text == "1" ? "" : " " + unit.text);
}

std::string as_json(const std::string& quantity) {
  return quantity.find(' ') == std::string::npos ? quantity : "\"" + quantity + "\"";
}

std::string repeated(const std::string& text, int count) {
  std::string list;
  for (int i = 0; i < count; ++i) list += (i ? ", " : "") + text;
  return "[" + list + "]";
}

}  // namespace

std::string example_of(const ParameterSpec& spec, const PortUnits& ports) {
  if (!spec.default_json.empty()) return spec.default_json;
  if (spec.type == ParameterType::integer) return number_text(std::ceil(number_in_range(spec)));
  const std::string element = as_json(example_quantity(spec, ports));
  if (spec.type == ParameterType::matrix)
    return repeated(repeated(element, std::max(1, spec.cols)), std::max(1, spec.size));
  const bool is_list = spec.type == ParameterType::vector && spec.size_of_port.empty();
  return is_list ? repeated(element, std::max(1, spec.size)) : element;
}

std::string expected_text(const ParameterSpec& spec, const PortUnits& ports) {
  const bool is_number = spec.type == ParameterType::number, is_time = spec.type == ParameterType::time;
  if (spec.type == ParameterType::choice) return describe_short(spec, ports);
  std::string text = is_number && wanted_unit(spec, ports).text == "1" ? "a number" : words_of(spec.type).expected;
  const bool is_sized = !spec.size_of_port.empty() || spec.size != ParameterSpec::any_size;
  if (spec.type == ParameterType::vector && is_sized) text += ", or one for all";
  const std::string detail = is_number                             ? unit_and_range(spec, ports)
                             : spec.type == ParameterType::integer ? range_text(spec)
                             : takes_quantities(spec.type)         ? describe_short(spec, ports)
                                                                   : "";
  if (!detail.empty()) text += " (" + detail + ")";
  return is_number || is_time ? text + ", for example " + example_of(spec, ports) : text;
}

}  // namespace binnacle::internal::spec

namespace binnacle {

std::string requirement_text(const ParameterSpec& spec) { return internal::spec::describe_short(spec); }
std::string example_text(const ParameterSpec& spec) { return internal::spec::example_of(spec); }

}  // namespace binnacle
