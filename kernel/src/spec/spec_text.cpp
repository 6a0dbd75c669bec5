// SPDX-License-Identifier: Apache-2.0
// What a spec asks for, in words.
#include "spec/spec_text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace binnacle::spec {

std::optional<std::string> port_of_unit(std::string_view unit) {
  if (!unit.starts_with('@')) return std::nullopt;
  const std::string_view port = unit.substr(1, unit.find_first_of("*/^.", 1) - 1);
  return std::string(port);
}

WantedUnit wanted_unit(const ParameterSpec& spec, const PortUnits& ports) {
  if (spec.unit == "*") return {std::nullopt, "any unit"};
  const std::optional<std::string> port = port_of_unit(spec.unit);
  if (!port) {
    const std::optional<Unit> unit = parse_unit(spec.unit.empty() ? "1" : spec.unit);
    return unit ? WantedUnit{unit->dimension, si_unit(unit->dimension)} : WantedUnit{std::nullopt, spec.unit};
  }
  const std::optional<PortMeasure> measure = ports ? ports(*port) : std::nullopt;
  if (!measure) return {std::nullopt, "unit of " + spec.unit.substr(1)};
  const std::string_view factor = std::string_view(spec.unit).substr(1 + port->size());
  const std::optional<Unit> unit = parse_unit("(" + si_unit(measure->dimension) + ")" + std::string(factor));
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
  if (std::isfinite(spec.maximum)) {
    text +=
        (text.empty() ? "" : ", ") + std::string(spec.maximum_excluded ? "< " : "<= ") + number_text(spec.maximum, 6);
  }
  return text;
}

bool in_range(const ParameterSpec& spec, double value) {
  const bool above = spec.minimum_excluded ? value > spec.minimum : value >= spec.minimum;
  const bool below = spec.maximum_excluded ? value < spec.maximum : value <= spec.maximum;
  return above && below;
}

std::string quoted_list(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "'" : ", '") + word + "'";
  return text;
}

std::string bare_dimension_name(const Dimension& dimension) {
  const std::string name = dimension_name(dimension);
  return name.substr(0, name.find(" ("));
}

namespace {

std::string joined(const std::string& a, const std::string& b) { return a.empty() || b.empty() ? a + b : a + ", " + b; }

std::string unit_and_range(const ParameterSpec& spec, const PortUnits& ports) {
  const std::string unit = wanted_unit(spec, ports).text;
  return joined(unit == "1" ? "" : unit, range_text(spec));
}

std::string values_text(int count) { return std::to_string(count) + (count == 1 ? " value" : " values"); }

std::string shape_text(const ParameterSpec& spec, const PortUnits& ports) {
  const bool is_matrix = spec.type == ParameterType::matrix;
  if (!spec.size_of_port.empty()) {
    const std::optional<PortMeasure> measure = ports ? ports(spec.size_of_port) : std::nullopt;
    if (!measure) return (is_matrix ? "square, as large as " : "as many as ") + spec.size_of_port;
    const std::string n = std::to_string(measure->dof);
    return is_matrix ? n + " by " + n : values_text(measure->dof);
  }
  if (!is_matrix) return spec.size == ParameterSpec::any_size ? "list" : values_text(spec.size);
  const auto side = [](int n) { return n == ParameterSpec::any_size ? std::string("any") : std::to_string(n); };
  const bool is_free = spec.size == ParameterSpec::any_size && spec.cols == ParameterSpec::any_size;
  return is_free ? "matrix" : side(spec.size) + " by " + side(spec.cols);
}

}  // namespace

std::string describe_short(const ParameterSpec& spec, const PortUnits& ports) {
  switch (spec.type) {
    case ParameterType::number: {
      const std::string text = unit_and_range(spec, ports);
      return text.empty() ? "plain number" : text;
    }
    case ParameterType::integer: return joined("integer", range_text(spec));
    case ParameterType::boolean: return "true or false";
    case ParameterType::text: return "text";
    case ParameterType::choice: return "one of " + quoted_list(spec.choices);
    case ParameterType::path: return "file or folder";
    case ParameterType::vector:
    case ParameterType::matrix: return joined(shape_text(spec, ports), unit_and_range(spec, ports));
    case ParameterType::time: return joined("s", range_text(spec));
    case ParameterType::list: return "list";
    case ParameterType::map: return "object with free keys";
    case ParameterType::object: return "object";
  }
  return {};
}

namespace {

struct Example {
  std::string_view unit;  // SI
  std::string_view text;
};

constexpr Example examples[] = {
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
  for (const Example& example : examples) {
    if (example.unit != unit.text) continue;
    const Parsed<Quantity> quantity = parse_quantity(example.text);
    if (quantity && in_range(spec, quantity->value)) return std::string(example.text);
  }
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
  const std::string element = takes_quantities(spec.type) ? as_json(example_quantity(spec, ports)) : "";
  switch (spec.type) {
    case ParameterType::number:
    case ParameterType::time: return element;
    case ParameterType::integer: return number_text(std::ceil(number_in_range(spec)));
    case ParameterType::boolean: return "true";
    case ParameterType::text: return "\"\"";
    case ParameterType::choice: return spec.choices.empty() ? "\"\"" : "\"" + spec.choices.front() + "\"";
    case ParameterType::path: return "\"FILE\"";
    case ParameterType::vector:
      if (!spec.size_of_port.empty()) return element;
      return repeated(element, spec.size == ParameterSpec::any_size ? 1 : spec.size);
    case ParameterType::matrix: return repeated(repeated(element, std::max(1, spec.cols)), std::max(1, spec.size));
    case ParameterType::list: return spec.members.empty() ? "[]" : "[" + example_of(spec.members.front(), ports) + "]";
    case ParameterType::map:
      return spec.members.empty() ? "{}" : "{\"NAME\": " + example_of(spec.members.front(), ports) + "}";
    case ParameterType::object: {
      std::string text;
      for (const ParameterSpec& member : spec.members) {
        if (member.is_required)
          text += (text.empty() ? "" : ", ") + ("\"" + member.name + "\": ") + example_of(member, ports);
      }
      return "{" + text + "}";
    }
  }
  return "null";
}

std::string expected_text(const ParameterSpec& spec, const PortUnits& ports) {
  const auto in_parentheses = [](const std::string& text) { return text.empty() ? text : " (" + text + ")"; };
  switch (spec.type) {
    case ParameterType::number: {
      const std::string unit = wanted_unit(spec, ports).text;
      const std::string noun = unit == "1" ? "a number" : "a number or text with a unit";
      return noun + in_parentheses(unit_and_range(spec, ports)) + ", for example " + example_of(spec, ports);
    }
    case ParameterType::integer: return "an integer" + in_parentheses(range_text(spec));
    case ParameterType::boolean: return "true or false";
    case ParameterType::text: return "a text";
    case ParameterType::choice: return "one of " + quoted_list(spec.choices);
    case ParameterType::path: return "the name of a file or folder";
    case ParameterType::vector: {
      const bool is_sized = !spec.size_of_port.empty() || spec.size != ParameterSpec::any_size;
      return std::string("a list of numbers or texts with a unit") + (is_sized ? ", or one for all" : "") +
             in_parentheses(describe_short(spec, ports));
    }
    case ParameterType::matrix: return "a list of rows, each a list" + in_parentheses(describe_short(spec, ports));
    case ParameterType::time:
      return "a time" + in_parentheses(describe_short(spec, ports)) + ", for example " + example_of(spec, ports);
    case ParameterType::list: return "a list";
    case ParameterType::map:
    case ParameterType::object: return "an object";
  }
  return {};
}

}  // namespace binnacle::spec

namespace binnacle {

std::string requirement_text(const ParameterSpec& spec) { return spec::describe_short(spec); }
std::string example_text(const ParameterSpec& spec) { return spec::example_of(spec); }

}  // namespace binnacle
