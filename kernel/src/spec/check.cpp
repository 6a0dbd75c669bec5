// SPDX-License-Identifier: Apache-2.0
// Checking JSON against specs: every value becomes SI or a diagnostic.
#include "spec/check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "base/text.hpp"
#include "config/pointer.hpp"
#include "spec/spec_text.hpp"

namespace binnacle::spec {

using Json = nlohmann::ordered_json;

namespace {

using base::in_quotes;

std::string cut(std::string text) {
  constexpr std::size_t longest = 40;
  if (text.size() <= longest) return text;
  std::size_t end = longest - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not inside a UTF-8 character
  return text.substr(0, end) + "...";
}

std::string count_text(std::size_t n, const char* singular, const char* plural) {
  return std::to_string(n) + " " + (n == 1 ? singular : plural);
}

}  // namespace

std::string abbreviated(const Json& value) {
  switch (value.type()) {
    case Json::value_t::string: return "the text \"" + cut(value.get_ref<const std::string&>()) + "\"";
    case Json::value_t::object: return value.empty() ? "an empty object" : "an object";
    case Json::value_t::array: return value.empty() ? "an empty list" : "a list of " + std::to_string(value.size());
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
    case Json::value_t::number_float: return "the number " + cut(value.dump());
    default: return value.dump();
  }
}

namespace {

/// A value on its way through the check. A default has no place of its own: messages point at its component.
struct Node {
  const Json& json;
  std::string label;  // how messages call it
  std::string pointer;
  bool is_default = false;

  Node element(std::size_t i) const {
    return {json[i], label, is_default ? pointer : join_pointer(pointer, i), is_default};
  }
  Node member(const std::string& key, std::string member_label) const {
    return {json.at(key), std::move(member_label), is_default ? pointer : join_pointer(pointer, key), is_default};
  }
};

std::string unknown_hint(const std::string& near, const std::string& detail, const std::vector<std::string>& known) {
  constexpr std::size_t most = 16;
  if (!near.empty()) return "; did you mean " + in_quotes(near) + detail + "?";
  if (known.empty()) return "; it takes none";
  return known.size() > most ? "" : "; it takes " + quoted_list(known);
}

std::string renamed_hint(const std::string& former, const std::string& name) {
  return "; " + in_quotes(former) + " is now called " + in_quotes(name);
}

std::string renamed_to(const std::string& key, const RenamedKeys& renamed) {
  for (const auto& [former, name] : renamed)
    if (key == former) return name;
  return {};
}

using Type = ParameterValue::Type;

class Checker {
 public:
  Checker(const Document& document, const PortUnits& ports, Diagnostics& diagnostics)
      : document_(document), ports_(ports), diagnostics_(diagnostics) {}

  ParameterValue value(const ParameterSpec& spec, const Node& node) {
    switch (spec.type) {
      case ParameterType::number: return number(spec, node);
      case ParameterType::integer: return integer(spec, node);
      case ParameterType::boolean: return boolean(spec, node);
      case ParameterType::text: return text(spec, node);
      case ParameterType::choice: return choice(spec, node);
      case ParameterType::path: return path(spec, node);
      case ParameterType::vector: return vector(spec, node);
      case ParameterType::matrix: return matrix(spec, node);
      case ParameterType::time: return time(spec, node);
      case ParameterType::list: return list(spec, node);
      case ParameterType::map: return map(spec, node);
      case ParameterType::object: return object(spec, node);
    }
    return {};
  }

  ParameterValue members(const std::vector<ParameterSpec>& specs, const Node& node,
                         const std::vector<std::string>& reserved) {
    ParameterValue result;
    result.type = Type::object;
    const std::set<std::string> meant = unknown_keys(specs, node, reserved);
    for (const ParameterSpec& spec : specs) {
      ParameterValue member = member_value(spec, node, meant.contains(spec.name));
      if (member.type != Type::absent) result.members.emplace_back(spec.name, std::move(member));
    }
    return result;
  }

 private:
  // -- messages

  void error(const Node& node, const char* code, const std::string& message) {
    diagnostics_.error(code, document_.origin(node.pointer), node.pointer,
                       node.is_default ? "default of " + in_quotes(node.label) + ": " + message : message);
  }

  ParameterValue wrong_type(const ParameterSpec& spec, const Node& node) {
    error(node, "B006",
          in_quotes(node.label) + " must be " + expected_text(spec, ports_) + "; found " + abbreviated(node.json));
    return {};
  }

  /// Of what a quantity is, with unit and range.
  std::string nature(const ParameterSpec& spec, const Node& node, const WantedUnit& unit) const {
    const std::string range = range_text(spec);
    std::string inside = unit.text == "1" ? "" : unit.text;
    if (!range.empty()) inside += (inside.empty() ? "" : ", ") + range;
    const std::string name = unit.dimension ? bare_dimension_name(*unit.dimension) : "a number";
    return in_quotes(node.label) + " is " + name + (inside.empty() ? "" : " (" + inside + ")") + ", for example " +
           scalar_example(spec, node);
  }

  std::string scalar_example(const ParameterSpec& spec, const Node& node) const {
    ParameterSpec scalar = spec;
    if (scalar.type != ParameterType::time) scalar.type = ParameterType::number;
    if (spec.type != scalar.type || node.is_default) scalar.default_json.clear();
    return example_of(scalar, ports_);
  }

  void out_of_range(const ParameterSpec& spec, const Node& node, const WantedUnit& unit, const std::string& written) {
    const std::string si = unit.text == "1" || !unit.dimension ? "" : unit.text + ", ";
    error(node, "B009", in_quotes(node.label) + " is " + written + ", out of range (" + si + range_text(spec) + ")");
  }

  // -- numbers

  /// In SI. `unit_out`: the SI unit it came in.
  std::optional<double> quantity(const ParameterSpec& spec, const Node& node, const ParameterSpec& whole,
                                 std::string* unit_out = nullptr) {
    WantedUnit unit = wanted_unit(spec, ports_);
    double value = 0;
    std::string written;
    if (node.json.is_number()) {
      value = node.json.get<double>();
      written = number_text(value) + (unit.text == "1" || !unit.dimension ? "" : " " + unit.text);
      if (!unit.dimension) unit.text = "1";
    } else if (node.json.is_string()) {
      written = node.json.get<std::string>();
      const std::optional<Quantity> parsed = parsed_quantity(spec, node, unit, written);
      if (!parsed) return std::nullopt;
      value = parsed->value;
      if (!unit.dimension) unit.text = si_unit(parsed->dimension);
    } else {
      wrong_type(whole, node);
      return std::nullopt;
    }
    if (unit_out) *unit_out = unit.text;
    if (std::isfinite(value) && in_range(spec, value)) return value;
    if (!std::isfinite(value)) {
      error(node, "B009", in_quotes(node.label) + " is beyond the range of a double");
    } else {
      out_of_range(spec, node, unit, written);
    }
    return std::nullopt;
  }

  std::optional<Quantity> parsed_quantity(const ParameterSpec& spec, const Node& node, const WantedUnit& unit,
                                          const std::string& written) {
    if (spec.unit == "*") {
      const Parsed<Unit> alone = read_unit(written);
      if (alone) return Quantity{alone->scale, alone->dimension};
      if (written.find_first_of("0123456789") == std::string::npos) {
        error(node, "B008", in_quotes(node.label) + ": " + alone.error());
        return std::nullopt;
      }
    }
    const Parsed<Quantity> parsed = parse_quantity(written);
    if (!parsed) {
      error(node, "B008", in_quotes(node.label) + ": " + parsed.error());
      return std::nullopt;
    }
    if (!unit.dimension || *unit.dimension == parsed->dimension) return *parsed;
    const bool has_unit = written.find_first_not_of("+-0123456789.eE \t") != std::string::npos;
    error(node, "B007",
          in_quotes(cut(written)) + (has_unit ? " is " + bare_dimension_name(parsed->dimension) : " has no unit") +
              "; " + nature(spec, node, unit));
    return std::nullopt;
  }

  ParameterValue number(const ParameterSpec& spec, const Node& node) {
    ParameterValue result;
    const std::optional<double> value = quantity(spec, node, spec, &result.text);
    if (!value) return {};
    result.type = Type::number;
    result.number = *value;
    return result;
  }

  ParameterValue integer(const ParameterSpec& spec, const Node& node) {
    constexpr double largest = 9007199254740992.0;  // 2^53: a double beyond is no exact count
    if (!node.json.is_number()) return wrong_type(spec, node);
    const double as_double = node.json.get<double>();
    if (node.json.is_number_float() && (as_double != std::floor(as_double) || std::abs(as_double) > largest)) {
      return wrong_type(spec, node);
    }
    const bool fits =
        !node.json.is_number_unsigned() ||
        node.json.get<std::uint64_t>() <= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    if (!fits || !in_range(spec, as_double)) {
      const std::string range = fits ? range_text(spec) : "64 bits";
      error(node, "B009", in_quotes(node.label) + " is " + node.json.dump() + ", out of range (" + range + ")");
      return {};
    }
    ParameterValue result;
    result.type = Type::integer;
    result.integer = node.json.is_number_float() ? static_cast<std::int64_t>(as_double) : node.json.get<std::int64_t>();
    return result;
  }

  ParameterValue time(const ParameterSpec& spec, const Node& node) {
    const std::optional<double> in_seconds = quantity(spec, node, spec);
    if (!in_seconds) return {};
    ParameterValue result;
    result.type = Type::integer;
    if (node.json.is_string()) {
      // Once more and exactly, which a double is not.
      const Parsed<std::int64_t> exact = parse_time(node.json.get_ref<const std::string&>());
      if (!exact) {
        error(node, "B008", in_quotes(node.label) + ": " + exact.error());
        return {};
      }
      result.integer = *exact;
      return result;
    }
    if (std::abs(*in_seconds) >= 9.2e9) {
      error(node, "B009", in_quotes(node.label) + " is " + node.json.dump() + " s, beyond 292 years");
      return {};
    }
    result.integer = from_seconds(*in_seconds);
    return result;
  }

  /// Nothing where any length is right.
  std::optional<int> wanted_size(const ParameterSpec& spec, int size) const {
    if (!spec.size_of_port.empty()) {
      const std::optional<PortMeasure> measure = ports_ ? ports_(spec.size_of_port) : std::nullopt;
      return measure ? std::optional<int>(measure->dof) : std::nullopt;
    }
    return size == ParameterSpec::any_size ? std::nullopt : std::optional<int>(size);
  }

  ParameterValue vector(const ParameterSpec& spec, const Node& node) {
    const std::optional<int> size = wanted_size(spec, spec.size);
    const bool may_broadcast = size || !spec.size_of_port.empty();
    ParameterValue result;
    result.type = Type::vector;
    if (!node.json.is_array()) {
      if (!may_broadcast) return wrong_type(spec, node);
      const std::optional<double> all = quantity(spec, node, spec);
      if (!all) return {};
      result.numbers.assign(static_cast<std::size_t>(size.value_or(1)), *all);
    } else {
      if (size && static_cast<int>(node.json.size()) != *size) {
        error(node, "B013",
              in_quotes(node.label) + " has " + count_text(node.json.size(), "element", "elements") + "; it takes " +
                  describe_short(spec, ports_));
        return {};
      }
      const std::size_t good = elements(spec, node, result.numbers);
      if (good != node.json.size()) return {};
    }
    result.rows = static_cast<int>(result.numbers.size());
    result.cols = 1;
    return result;
  }

  /// Appends what is right and returns how many were.
  std::size_t elements(const ParameterSpec& spec, const Node& node, std::vector<double>& numbers) {
    ParameterSpec element = spec;
    element.type = ParameterType::number;
    std::size_t good = 0;
    for (std::size_t i = 0; i < node.json.size(); ++i) {
      const std::optional<double> number = quantity(spec, node.element(i), element);
      if (!number) continue;
      numbers.push_back(*number);
      ++good;
    }
    return good;
  }

  ParameterValue matrix(const ParameterSpec& spec, const Node& node) {
    const std::optional<int> rows = wanted_size(spec, spec.size);
    const std::optional<int> cols = wanted_size(spec, spec.cols);
    const bool is_list_of_lists =
        node.json.is_array() && !node.json.empty() &&
        std::all_of(node.json.begin(), node.json.end(), [](const Json& row) { return row.is_array(); });
    if (!is_list_of_lists) return wrong_type(spec, node);
    const std::size_t width = node.json.front().size();
    for (std::size_t i = 0; i < node.json.size(); ++i) {
      if (node.json[i].size() == width) continue;
      error(node.element(i), "B013",
            "row " + std::to_string(i) + " of " + in_quotes(node.label) + " has " +
                count_text(node.json[i].size(), "element", "elements") + ", the first has " + std::to_string(width));
      return {};
    }
    if ((rows && static_cast<std::size_t>(*rows) != node.json.size()) ||
        (cols && static_cast<std::size_t>(*cols) != width)) {
      error(node, "B013",
            in_quotes(node.label) + " is " + std::to_string(node.json.size()) + " by " + std::to_string(width) +
                "; it takes " + describe_short(spec, ports_));
      return {};
    }
    std::vector<double> row_major;
    std::size_t good = 0;
    for (std::size_t i = 0; i < node.json.size(); ++i) good += elements(spec, node.element(i), row_major);
    if (good != width * node.json.size()) return {};
    return column_major(row_major, node.json.size(), width);
  }

  static ParameterValue column_major(const std::vector<double>& row_major, std::size_t rows, std::size_t cols) {
    ParameterValue result;
    result.type = Type::matrix;
    result.rows = static_cast<int>(rows);
    result.cols = static_cast<int>(cols);
    for (std::size_t j = 0; j < cols; ++j)
      for (std::size_t i = 0; i < rows; ++i) result.numbers.push_back(row_major[i * cols + j]);
    return result;
  }

  // -- words

  ParameterValue boolean(const ParameterSpec& spec, const Node& node) {
    if (!node.json.is_boolean()) return wrong_type(spec, node);
    ParameterValue result;
    result.type = Type::boolean;
    result.boolean = node.json.get<bool>();
    return result;
  }

  ParameterValue text(const ParameterSpec& spec, const Node& node) {
    if (!node.json.is_string()) return wrong_type(spec, node);
    return as_text(node.json.get<std::string>());
  }

  static ParameterValue as_text(std::string text) {
    ParameterValue result;
    result.type = Type::text;
    result.text = std::move(text);
    return result;
  }

  ParameterValue choice(const ParameterSpec& spec, const Node& node) {
    if (!node.json.is_string()) return wrong_type(spec, node);
    const auto& word = node.json.get_ref<const std::string&>();
    if (std::find(spec.choices.begin(), spec.choices.end(), word) != spec.choices.end()) return as_text(word);
    const std::string near = closest(word, spec.choices);
    error(node, "B014",
          in_quotes(node.label) + " cannot be " + in_quotes(cut(word)) + "; " +
              (near.empty() ? "it is one of " : "did you mean " + in_quotes(near) + "? It is one of ") +
              quoted_list(spec.choices));
    return {};
  }

  ParameterValue path(const ParameterSpec& spec, const Node& node) {
    if (!node.json.is_string()) return wrong_type(spec, node);
    const auto& name = node.json.get_ref<const std::string&>();
    if (name.empty()) {
      if (node.is_default) return as_text("");
      return wrong_type(spec, node);
    }
    if (node.is_default) return as_text((document_.base_dir(node.pointer) / name).lexically_normal().string());
    return as_text(document_.resolve_path(node.pointer));
  }

  // -- structure

  ParameterValue list(const ParameterSpec& spec, const Node& node) {
    if (!node.json.is_array()) return wrong_type(spec, node);
    ParameterValue result;
    result.type = Type::list;
    for (std::size_t i = 0; i < node.json.size(); ++i) {
      result.elements.push_back(value(spec.members.front(), node.element(i)));
    }
    return result;
  }

  ParameterValue map(const ParameterSpec& spec, const Node& node) {
    if (!node.json.is_object()) return wrong_type(spec, node);
    ParameterValue result;
    result.type = Type::object;
    for (const auto& [key, json] : node.json.items()) {
      result.members.emplace_back(key, value(spec.members.front(), node.member(key, key)));
    }
    return result;
  }

  ParameterValue object(const ParameterSpec& spec, const Node& node) {
    if (!node.json.is_object()) return wrong_type(spec, node);
    return members(spec.members, node, {});
  }

  ParameterValue member_value(const ParameterSpec& spec, const Node& node, bool is_misspelt) {
    if (node.json.contains(spec.name)) return value(spec, node.member(spec.name, spec.name));
    if (!spec.default_json.empty()) {
      const Json json = Json::parse(spec.default_json, nullptr, false);
      if (!json.is_discarded()) return value(spec, {json, spec.name, node.pointer, true});
      error({json, spec.name, node.pointer, true}, "B001", "no JSON: " + spec.default_json);
      return {};
    }
    if (spec.is_required && !is_misspelt) missing(spec, node);
    return {};
  }

  void missing(const ParameterSpec& spec, const Node& node) {
    std::string message = "missing key " + in_quotes(spec.name) + " of " + in_quotes(node.label);
    if (!spec.text.empty()) message += ": " + spec.text;
    message += " (" + describe_short(spec, ports_) + ")";
    if (takes_quantities(spec.type)) message += ", for example " + example_of(spec, ports_);
    error(node, "B010", message);
  }

  /// The names that were meant by unknown keys; saying that they are missing as well would be noise.
  std::set<std::string> unknown_keys(const std::vector<ParameterSpec>& specs, const Node& node,
                                     const std::vector<std::string>& reserved) {
    std::vector<std::string> known = reserved;
    for (const ParameterSpec& spec : specs) known.push_back(spec.name);
    std::set<std::string> meant;
    for (const auto& [key, json] : node.json.items()) {
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      const auto renamed = std::find_if(specs.begin(), specs.end(),
                                        [&, &key = key](const ParameterSpec& s) { return s.former_name == key; });
      const std::string near = renamed != specs.end() ? renamed->name : closest(key, known);
      const auto spec =
          std::find_if(specs.begin(), specs.end(), [&](const ParameterSpec& s) { return s.name == near; });
      const std::string detail = spec == specs.end() ? "" : " (" + describe_short(*spec, ports_) + ")";
      const std::string place = node.is_default ? node.pointer : join_pointer(node.pointer, key);
      diagnostics_.error("B012", document_.key_origin(place), place,
                         "unknown key of " + in_quotes(node.label) +
                             (renamed != specs.end() ? renamed_hint(key, near) : unknown_hint(near, detail, known)));
      if (!near.empty()) meant.insert(near);
    }
    return meant;
  }

  const Document& document_;
  const PortUnits& ports_;
  Diagnostics& diagnostics_;
};

}  // namespace

ParameterValue check_parameters(const std::vector<ParameterSpec>& parameters, std::string_view type_name,
                                const Document& document, const std::string& pointer,
                                const std::vector<std::string>& reserved_keys, const PortUnits& ports,
                                Diagnostics& diagnostics) {
  const Json empty = Json::object();
  const Json* json = value_at(document, pointer);
  if (json && !json->is_object()) {
    diagnostics.error("B006", document.origin(pointer), pointer,
                      in_quotes(type_name) + " must be an object; found " + abbreviated(*json));
    return {};
  }
  Checker checker(document, ports, diagnostics);
  return checker.members(parameters, {json ? *json : empty, std::string(type_name), pointer}, reserved_keys);
}

ParameterValue check_value(const ParameterSpec& spec, const Document& document, const std::string& pointer,
                           const PortUnits& ports, Diagnostics& diagnostics) {
  const Json* json = value_at(document, pointer);
  if (!json) return {};
  return Checker(document, ports, diagnostics).value(spec, {*json, spec.name, pointer});
}

void check_keys(const Document& document, const std::string& pointer, const std::vector<std::string>& allowed,
                std::string_view what, Diagnostics& diagnostics, const RenamedKeys& renamed_keys) {
  const Json* json = value_at(document, pointer);
  if (!json || !json->is_object()) return;
  for (const auto& [key, value] : json->items()) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    const std::string place = join_pointer(pointer, key);
    const std::string renamed = renamed_to(key, renamed_keys);
    diagnostics.error("B012", document.key_origin(place), place,
                      "unknown key of " + std::string(what) +
                          (renamed.empty() ? unknown_hint(closest(key, allowed), "", allowed)
                                           : renamed_hint(key, renamed)));
  }
}

// ---- specs themselves

namespace {

void check_unit(const ParameterSpec& spec, const ComponentSpec& component, std::vector<std::string>& defects) {
  const bool has_unit = takes_quantities(spec.type) || !spec.unit.empty();
  if (!has_unit || spec.unit == "*") return;
  const auto is_port = [&](const std::string& name) {
    return std::any_of(component.ports.begin(), component.ports.end(),
                       [&](const PortSpec& p) { return p.name == name; });
  };
  if (!spec.size_of_port.empty() && !is_port(spec.size_of_port))
    defects.push_back("parameter '" + spec.name + "' is sized by the port '" + spec.size_of_port + "', which it lacks");
  const std::optional<std::string> port = port_of_unit(spec.unit);
  if (port && !is_port(*port))
    defects.push_back("parameter '" + spec.name + "' has the unit of the port '" + *port + "', which it lacks");
  const std::string text = port ? "(m)" + spec.unit.substr(1 + port->size()) : spec.unit.empty() ? "1" : spec.unit;
  const Parsed<Unit> unit = read_unit(text);
  if (!unit) defects.push_back("parameter '" + spec.name + "': " + unit.error());
  if (unit && unit->scale != 1.0)
    defects.push_back("parameter '" + spec.name + "': the unit '" + spec.unit + "' is not SI");
}

void check_specs(const std::vector<ParameterSpec>& specs, const ComponentSpec& component, bool are_named,
                 std::vector<std::string>& defects) {
  std::set<std::string> names;
  for (const ParameterSpec& spec : specs) {
    if (are_named && !names.insert(spec.name).second) defects.push_back("parameter '" + spec.name + "' stands twice");
    if (are_named && spec.name.empty()) defects.push_back("a parameter has no name");
    const bool has_element = spec.type == ParameterType::list || spec.type == ParameterType::map;
    if (has_element && spec.members.size() != 1) {
      defects.push_back("parameter '" + spec.name + "' needs one element spec");
      continue;
    }
    if (spec.type == ParameterType::choice && spec.choices.empty())
      defects.push_back("parameter '" + spec.name + "' has nothing to choose from");
    if (spec.is_required && !spec.default_json.empty())
      defects.push_back("parameter '" + spec.name + "' is required and has a default");
    check_unit(spec, component, defects);
    check_specs(spec.members, component, !has_element, defects);
  }
}

/// Optional objects and lists are looked into as well: their defaults show when they are given.
void check_defaults(const std::vector<ParameterSpec>& specs, std::vector<std::string>& defects) {
  const Document none;
  const PortUnits no_ports;
  for (const ParameterSpec& spec : specs) {
    check_defaults(spec.members, defects);
    if (spec.default_json.empty()) continue;
    ParameterSpec named = spec;
    named.is_required = false;
    Diagnostics diagnostics;
    check_parameters({named}, spec.name, none, "", {}, no_ports, diagnostics);
    for (const Diagnostic& item : diagnostics.items()) defects.push_back(item.message);
  }
}

void check_names(const ComponentSpec& spec, std::vector<std::string>& defects) {
  std::set<std::string> ports;
  for (const PortSpec& port : spec.ports) {
    if (!ports.insert(port.name).second) defects.push_back("port '" + port.name + "' stands twice");
  }
  const auto check_fields = [&](const std::vector<FieldSpec>& fields) {
    std::set<std::string> names;
    for (const FieldSpec& field : fields) {
      if (!names.insert(field.name).second) defects.push_back("field '" + field.name + "' stands twice");
      const Parsed<Unit> unit = read_unit(takes_any_unit(field) ? "1" : field.unit);
      if (!unit) defects.push_back("field '" + field.name + "': " + unit.error());
      if (unit && unit->scale != 1.0)
        defects.push_back("field '" + field.name + "': the unit '" + field.unit + "' is not SI");
    }
  };
  check_fields(spec.fields);
  check_fields(spec.driving_rates);
  for (const ChannelPort& input : spec.inputs) check_fields(input.fields);
}

}  // namespace

std::vector<std::string> spec_defects(const ComponentSpec& spec) {
  std::vector<std::string> defects;
  check_names(spec, defects);
  check_specs(spec.parameters, spec, true, defects);
  if (defects.empty()) check_defaults(spec.parameters, defects);
  return defects;
}

}  // namespace binnacle::spec
