// SPDX-License-Identifier: Apache-2.0
// Checking JSON against specs: every value becomes SI or a diagnostic.
#include "spec/check.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <type_traits>
#include <utility>

#include "base/index.hpp"
#include "base/text.hpp"
#include "spec/spec_text.hpp"

namespace binnacle::spec {

using Json = nlohmann::ordered_json;

namespace {

using base::as_size;
using base::in_quotes;
using base::quoted_list;

std::string cut(std::string text) {
  constexpr std::size_t longest = 40;
  if (text.size() <= longest) return text;
  std::size_t end = longest - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not inside a UTF-8 character
  return text.substr(0, end) + "...";
}

std::string elements_text(const Json& list) {
  return std::to_string(list.size()) + (list.size() == 1 ? " element" : " elements");
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

/// Reports each key of the object that is not allowed, with a hint at what was meant: the name that a renamed one has now,
/// the nearest one and its detail, or all there are. Returns the names that were meant.
std::set<std::string> find_unknown(const Json& object, const std::vector<std::string>& allowed,
                                   const RenamedKeys& renamed,
                                   const std::function<std::string(const std::string&)>& detail,
                                   const std::function<void(const std::string& key, const std::string& hint)>& report) {
  constexpr std::size_t most = 16;
  std::set<std::string> meant;
  for (const auto& [key, json] : object.items()) {
    if (std::find(allowed.begin(), allowed.end(), key) != allowed.end()) continue;
    const auto former =
        std::find_if(renamed.begin(), renamed.end(), [&, &k = key](const auto& r) { return r.first == k; });
    const std::string near = former != renamed.end() ? former->second : closest(key, allowed);
    if (former != renamed.end()) {
      report(key, "; " + in_quotes(key) + " is now called " + in_quotes(near));
    } else if (!near.empty()) {
      report(key, "; did you mean " + in_quotes(near) + detail(near) + "?");
    } else {
      report(key, allowed.empty()         ? "; it takes none"
                  : allowed.size() > most ? ""
                                          : "; it takes " + quoted_list(allowed));
    }
    if (!near.empty()) meant.insert(near);
  }
  return meant;
}

bool has_json_type(ParameterType type, const Json& json) {
  switch (type) {
    case ParameterType::boolean: return json.is_boolean();
    case ParameterType::integer: return json.is_number();
    case ParameterType::text:
    case ParameterType::choice:
    case ParameterType::path: return json.is_string();
    case ParameterType::list: return json.is_array();
    case ParameterType::map:
    case ParameterType::object: return json.is_object();
    default: return true;  // quantities are looked at one by one
  }
}

using Type = ParameterValue::Type;

template <class T>
ParameterValue made(Type type, T ParameterValue::*member, std::type_identity_t<T> value) {
  ParameterValue result;
  result.type = type;
  result.*member = std::move(value);
  return result;
}

class Checker {
 public:
  Checker(const Document& document, const PortUnits& ports, Diagnostics& diagnostics)
      : document_(document), ports_(ports), diagnostics_(diagnostics) {}

  ParameterValue value(const ParameterSpec& spec, const Node& node) {
    if (!has_json_type(spec.type, node.json)) return wrong_type(spec, node);
    switch (spec.type) {
      case ParameterType::number: return number(spec, node);
      case ParameterType::integer: return integer(spec, node);
      case ParameterType::boolean: return made(Type::boolean, &ParameterValue::boolean, node.json.get<bool>());
      case ParameterType::text: return made(Type::text, &ParameterValue::text, node.json.get<std::string>());
      case ParameterType::choice: return choice(spec, node);
      case ParameterType::path: return path(spec, node);
      case ParameterType::vector: return vector(spec, node);
      case ParameterType::matrix: return matrix(spec, node);
      case ParameterType::time: return time(spec, node);
      case ParameterType::list: return list(spec, node);
      case ParameterType::map: return map(spec, node);
      case ParameterType::object: return members(spec.members, node, {});
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

  /// Nothing, as the value is then.
  ParameterValue error(const Node& node, const char* code, const std::string& message) {
    diagnostics_.error(code, document_.origin(node.pointer), node.pointer,
                       node.is_default ? "default of " + in_quotes(node.label) + ": " + message : message);
    return {};
  }

  ParameterValue wrong_type(const ParameterSpec& spec, const Node& node) {
    return error(node, "B006",
                 in_quotes(node.label) + " must be " + expected_text(spec, ports_) + "; found " +
                     abbreviated(node.json));
  }

  std::string scalar_example(const ParameterSpec& spec, const Node& node) const {
    ParameterSpec scalar = spec;
    if (scalar.type != ParameterType::time) scalar.type = ParameterType::number;
    if (spec.type != scalar.type || node.is_default) scalar.default_json.clear();
    return example_of(scalar, ports_);
  }

  // -- numbers

  /// In SI, with the SI unit that it came in.
  ParameterValue number(const ParameterSpec& spec, const Node& node) {
    const WantedUnit unit = wanted_unit(spec, ports_);
    const std::string of_unit = unit.text == "1" || !unit.dimension ? "" : unit.text;
    ParameterValue result;
    std::string written;
    if (node.json.is_number()) {
      result.number = node.json.get<double>();
      result.text = unit.dimension ? unit.text : "1";
      written = number_text(result.number) + (of_unit.empty() ? "" : " " + of_unit);
    } else if (node.json.is_string()) {
      written = node.json.get<std::string>();
      const std::optional<Quantity> parsed = quantity(spec, node, unit, written);
      if (!parsed) return {};
      result.number = parsed->value;
      result.text = unit.dimension ? unit.text : si_unit(parsed->dimension);
    } else {
      return wrong_type(spec, node);
    }
    if (!std::isfinite(result.number))
      return error(node, "B009", in_quotes(node.label) + " is beyond the range of a double");
    if (!in_range(spec, result.number))
      return error(node, "B009",
                   in_quotes(node.label) + " is " + written + ", out of range (" + joined(of_unit, range_text(spec)) +
                       ")");
    result.type = Type::number;
    return result;
  }

  std::optional<Quantity> quantity(const ParameterSpec& spec, const Node& node, const WantedUnit& unit,
                                   const std::string& written) {
    Parsed<Quantity> parsed = parse_quantity(written);
    if (spec.unit == "*") {
      const Parsed<Unit> alone = read_unit(written);
      if (alone) return Quantity{alone->scale, alone->dimension};
      if (written.find_first_of("0123456789") == std::string::npos) parsed = Parsed<Quantity>::failure(alone.error());
    }
    if (!parsed) {
      error(node, "B008", in_quotes(node.label) + ": " + parsed.error());
      return std::nullopt;
    }
    if (!unit.dimension || *unit.dimension == parsed->dimension) return *parsed;
    const bool has_unit = written.find_first_not_of("+-0123456789.eE \t") != std::string::npos;
    const std::string inside = unit_and_range(spec, ports_);
    error(node, "B007",
          in_quotes(cut(written)) + (has_unit ? " is " + bare_dimension_name(parsed->dimension) : " has no unit") +
              "; " + in_quotes(node.label) + " is " + bare_dimension_name(*unit.dimension) +
              (inside.empty() ? "" : " (" + inside + ")") + ", for example " + scalar_example(spec, node));
    return std::nullopt;
  }

  ParameterValue integer(const ParameterSpec& spec, const Node& node) {
    constexpr double largest = 9007199254740992.0;  // 2^53: a double beyond is no exact count
    const double as_double = node.json.get<double>();
    const bool is_float = node.json.is_number_float();
    if (is_float && (as_double != std::floor(as_double) || std::abs(as_double) > largest))
      return wrong_type(spec, node);
    const bool fits = !node.json.is_number_unsigned() || std::in_range<std::int64_t>(node.json.get<std::uint64_t>());
    if (!fits || !in_range(spec, as_double))
      return error(node, "B009",
                   in_quotes(node.label) + " is " + node.json.dump() + ", out of range (" +
                       (fits ? range_text(spec) : "64 bits") + ")");
    return made(Type::integer, &ParameterValue::integer,
                is_float ? static_cast<std::int64_t>(as_double) : node.json.get<std::int64_t>());
  }

  ParameterValue time(const ParameterSpec& spec, const Node& node) {
    const ParameterValue in_seconds = number(spec, node);
    if (in_seconds.type == Type::absent) return {};
    if (node.json.is_string()) {  // once more and exactly, which a double is not
      const Parsed<std::int64_t> exact = parse_time(node.json.get_ref<const std::string&>());
      if (!exact) return error(node, "B008", in_quotes(node.label) + ": " + exact.error());
      return made(Type::integer, &ParameterValue::integer, *exact);
    }
    if (std::abs(in_seconds.number) >= 9.2e9)
      return error(node, "B009", in_quotes(node.label) + " is " + node.json.dump() + " s, beyond 292 years");
    return made(Type::integer, &ParameterValue::integer, from_seconds(in_seconds.number));
  }

  /// Nothing where any length is right.
  std::optional<std::size_t> wanted_size(const ParameterSpec& spec, int size) const {
    if (!spec.size_of_port.empty()) {
      const std::optional<PortMeasure> measure = ports_ ? ports_(spec.size_of_port) : std::nullopt;
      return measure ? std::optional(as_size(measure->dof)) : std::nullopt;
    }
    return size == ParameterSpec::any_size ? std::nullopt : std::optional(as_size(size));
  }

  ParameterValue vector(const ParameterSpec& spec, const Node& node) {
    const std::optional<std::size_t> size = wanted_size(spec, spec.size);
    ParameterValue result;
    if (!node.json.is_array()) {
      if (!size && spec.size_of_port.empty()) return wrong_type(spec, node);
      const ParameterValue all = number(spec, node);
      if (all.type == Type::absent) return {};
      result.numbers.assign(size.value_or(1), all.number);
    } else {
      if (size && node.json.size() != *size)
        return error(node, "B013",
                     in_quotes(node.label) + " has " + elements_text(node.json) + "; it takes " +
                         describe_short(spec, ports_));
      if (!append_elements(spec, node, result.numbers)) return {};
    }
    result.type = Type::vector;
    result.rows = static_cast<int>(result.numbers.size());
    result.cols = 1;
    return result;
  }

  /// Appends what is right; whether all are.
  bool append_elements(const ParameterSpec& spec, const Node& node, std::vector<double>& numbers) {
    ParameterSpec element = spec;
    element.type = ParameterType::number;
    bool all_right = true;
    for (std::size_t i = 0; i < node.json.size(); ++i) {
      const ParameterValue value = number(element, node.element(i));
      if (value.type == Type::absent) all_right = false;
      numbers.push_back(value.number);
    }
    return all_right;
  }

  ParameterValue matrix(const ParameterSpec& spec, const Node& node) {
    const Json& json = node.json;
    if (!json.is_array() || json.empty() ||
        !std::all_of(json.begin(), json.end(), [](const Json& row) { return row.is_array(); }))
      return wrong_type(spec, node);
    const std::size_t rows = json.size(), cols = json.front().size();
    for (std::size_t i = 0; i < rows; ++i)
      if (json[i].size() != cols)
        return error(node.element(i), "B013",
                     "row " + std::to_string(i) + " of " + in_quotes(node.label) + " has " + elements_text(json[i]) +
                         ", the first has " + std::to_string(cols));
    if (wanted_size(spec, spec.size).value_or(rows) != rows || wanted_size(spec, spec.cols).value_or(cols) != cols)
      return error(node, "B013",
                   in_quotes(node.label) + " is " + std::to_string(rows) + " by " + std::to_string(cols) +
                       "; it takes " + describe_short(spec, ports_));
    std::vector<double> row_major;
    bool all_right = true;
    for (std::size_t i = 0; i < rows; ++i) all_right = append_elements(spec, node.element(i), row_major) && all_right;
    if (!all_right) return {};
    ParameterValue result;
    result.type = Type::matrix;
    result.rows = static_cast<int>(rows);
    result.cols = static_cast<int>(cols);
    for (std::size_t j = 0; j < cols; ++j)
      for (std::size_t i = 0; i < rows; ++i) result.numbers.push_back(row_major[i * cols + j]);
    return result;
  }

  // -- words

  ParameterValue choice(const ParameterSpec& spec, const Node& node) {
    const auto& word = node.json.get_ref<const std::string&>();
    if (std::find(spec.choices.begin(), spec.choices.end(), word) != spec.choices.end())
      return made(Type::text, &ParameterValue::text, word);
    const std::string near = closest(word, spec.choices);
    return error(node, "B014",
                 in_quotes(node.label) + " cannot be " + in_quotes(cut(word)) + "; " +
                     (near.empty() ? "it is one of " : "did you mean " + in_quotes(near) + "? It is one of ") +
                     quoted_list(spec.choices));
  }

  ParameterValue path(const ParameterSpec& spec, const Node& node) {
    const auto& name = node.json.get_ref<const std::string&>();
    if (name.empty() && !node.is_default) return wrong_type(spec, node);
    const std::string resolved =
        name.empty() ? "" : (document_.base_dir(node.pointer) / name).lexically_normal().string();
    return made(Type::text, &ParameterValue::text, resolved);
  }

  // -- structure

  ParameterValue list(const ParameterSpec& spec, const Node& node) {
    ParameterValue result;
    result.type = Type::list;
    for (std::size_t i = 0; i < node.json.size(); ++i)
      result.elements.push_back(value(spec.members.front(), node.element(i)));
    return result;
  }

  ParameterValue map(const ParameterSpec& spec, const Node& node) {
    ParameterValue result;
    result.type = Type::object;
    for (const auto& [key, json] : node.json.items())
      result.members.emplace_back(key, value(spec.members.front(), node.member(key, key)));
    return result;
  }

  ParameterValue member_value(const ParameterSpec& spec, const Node& node, bool is_misspelt) {
    if (node.json.contains(spec.name)) return value(spec, node.member(spec.name, spec.name));
    if (!spec.default_json.empty()) {
      const Json json = Json::parse(spec.default_json, nullptr, false);
      if (!json.is_discarded()) return value(spec, {json, spec.name, node.pointer, true});
      return error({json, spec.name, node.pointer, true}, "B001", "no JSON: " + spec.default_json);
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
    RenamedKeys renamed;
    for (const ParameterSpec& spec : specs) {
      known.push_back(spec.name);
      if (!spec.former_name.empty()) renamed.emplace_back(spec.former_name, spec.name);
    }
    const auto detail = [&](const std::string& name) {
      for (const ParameterSpec& spec : specs)
        if (spec.name == name) return " (" + describe_short(spec, ports_) + ")";
      return std::string();
    };
    return find_unknown(node.json, known, renamed, detail, [&](const std::string& key, const std::string& hint) {
      const std::string place = node.is_default ? node.pointer : join_pointer(node.pointer, key);
      diagnostics_.error("B012", document_.key_origin(place), place, "unknown key of " + in_quotes(node.label) + hint);
    });
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
  const Json* json = document.value(pointer);
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
  const Json* json = document.value(pointer);
  if (!json) return {};
  return Checker(document, ports, diagnostics).value(spec, {*json, spec.name, pointer});
}

void check_keys(const Document& document, const std::string& pointer, const std::vector<std::string>& allowed,
                std::string_view what, Diagnostics& diagnostics, const RenamedKeys& renamed) {
  const Json* json = document.value(pointer);
  if (!json || !json->is_object()) return;
  const auto no_detail = [](const std::string&) { return std::string(); };
  find_unknown(*json, allowed, renamed, no_detail, [&](const std::string& key, const std::string& hint) {
    const std::string place = join_pointer(pointer, key);
    diagnostics.error("B012", document.key_origin(place), place, "unknown key of " + std::string(what) + hint);
  });
}

// ---- specs themselves

namespace {

/// What is wrong with a unit that has to be SI, `who` in front.
void check_unit(const std::string& who, const std::string& written, const std::string& text,
                std::vector<std::string>& defects) {
  const Parsed<Unit> unit = read_unit(text);
  if (!unit) defects.push_back(who + ": " + unit.error());
  if (unit && unit->scale != 1.0) defects.push_back(who + ": the unit '" + written + "' is not SI");
}

void check_quantity(const std::string& who, const ParameterSpec& spec, const ComponentSpec& component,
                    std::vector<std::string>& defects) {
  if ((!takes_quantities(spec.type) && spec.unit.empty()) || spec.unit == "*") return;
  const auto lacks = [&](const std::string& port) {
    return std::none_of(component.ports.begin(), component.ports.end(),
                        [&](const PortSpec& p) { return p.name == port; });
  };
  if (!spec.size_of_port.empty() && lacks(spec.size_of_port))
    defects.push_back(who + " is sized by the port '" + spec.size_of_port + "', which it lacks");
  const std::optional<std::string> port = port_of_unit(spec.unit);
  if (port && lacks(*port)) defects.push_back(who + " has the unit of the port '" + *port + "', which it lacks");
  const std::string text = port ? "(m)" + spec.unit.substr(1 + port->size()) : spec.unit.empty() ? "1" : spec.unit;
  check_unit(who, spec.unit, text, defects);
}

void check_specs(const std::vector<ParameterSpec>& specs, const ComponentSpec& component, bool are_named,
                 std::vector<std::string>& defects) {
  std::set<std::string> names;
  for (const ParameterSpec& spec : specs) {
    const std::string who = "parameter '" + spec.name + "'";
    const auto unless = [&](bool is_right, const char* defect) {
      if (!is_right) defects.push_back(who + defect);
    };
    unless(!are_named || names.insert(spec.name).second, " stands twice");
    unless(!are_named || !spec.name.empty(), " has no name");
    const bool has_element = spec.type == ParameterType::list || spec.type == ParameterType::map;
    unless(!has_element || spec.members.size() == 1, " needs one element spec");
    if (has_element && spec.members.size() != 1) continue;
    unless(spec.type != ParameterType::choice || !spec.choices.empty(), " has nothing to choose from");
    unless(!spec.is_required || spec.default_json.empty(), " is required and has a default");
    check_quantity(who, spec, component, defects);
    check_specs(spec.members, component, !has_element, defects);
  }
}

/// Optional objects and lists are looked into as well: their defaults show when they are given.
void check_defaults(const std::vector<ParameterSpec>& specs, std::vector<std::string>& defects) {
  for (const ParameterSpec& spec : specs) {
    check_defaults(spec.members, defects);
    if (spec.default_json.empty()) continue;
    ParameterSpec named = spec;
    named.is_required = false;
    Diagnostics diagnostics;
    check_parameters({named}, spec.name, Document(), "", {}, {}, diagnostics);
    for (const Diagnostic& item : diagnostics.items()) defects.push_back(item.message);
  }
}

void check_fields(const std::vector<FieldSpec>& fields, std::vector<std::string>& defects) {
  std::set<std::string> names;
  for (const FieldSpec& field : fields) {
    const std::string who = "field '" + field.name + "'";
    if (!names.insert(field.name).second) defects.push_back(who + " stands twice");
    check_unit(who, field.unit, takes_any_unit(field) ? "1" : field.unit, defects);
  }
}

}  // namespace

std::vector<std::string> spec_defects(const ComponentSpec& spec) {
  std::vector<std::string> defects;
  std::set<std::string> ports;
  for (const PortSpec& port : spec.ports)
    if (!ports.insert(port.name).second) defects.push_back("port '" + port.name + "' stands twice");
  check_fields(spec.fields, defects);
  check_fields(spec.driving_rates, defects);
  for (const ChannelPort& input : spec.inputs) check_fields(input.fields, defects);
  check_specs(spec.parameters, spec, true, defects);
  if (defects.empty()) check_defaults(spec.parameters, defects);
  return defects;
}

}  // namespace binnacle::spec
