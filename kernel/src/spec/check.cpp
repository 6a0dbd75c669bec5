// SPDX-License-Identifier: Apache-2.0
// Checking JSON against specs: every value becomes SI or a diagnostic.
#include "spec/check.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "base/index.hpp"
#include "base/text.hpp"
#include "base/time_range.hpp"

namespace binnacle::internal::spec {

namespace {

using base::as_size;
using base::in_quotes;
using base::index_of;
using base::quoted_list;

std::string cut(const std::string& text) {
  constexpr std::size_t longest = 40;
  if (text.size() <= longest) return text;
  std::size_t end = longest - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not inside a UTF-8 character
  return text.substr(0, end) + "...";
}

/// dimension_name() without the unit in parentheses: "an angular rate".
std::string bare_dimension_name(const Dimension& dimension) {
  const std::string name = dimension_name(dimension);
  return name.substr(0, name.find(" ("));
}

std::string elements_text(const Json& list) {
  return std::to_string(list.size()) + (list.size() == 1 ? " element" : " elements");
}

/// A default "/origin" is what stands there in the config.
bool is_elsewhere(const ParameterSpec& spec) { return spec.default_json.starts_with('/'); }

using Type = ParameterValue::Type;

template <class T>
ParameterValue made(Type type, T ParameterValue::*member, std::type_identity_t<T> value) {
  ParameterValue result;
  result.type = type;
  result.*member = std::move(value);
  return result;
}

/// A value on its way through the check against its spec.
struct Check {
  const ParameterSpec& spec;
  const Reader& at;
  const PortUnits& ports;
  const std::string name;  // how messages call it, in quotes

  ParameterValue value() const {
    switch (spec.type) {
      case ParameterType::number: return number();
      case ParameterType::integer: return json().is_number() ? integer() : wrong_type();
      case ParameterType::boolean:
        return json().is_boolean() ? made(Type::boolean, &ParameterValue::boolean, json().get<bool>()) : wrong_type();
      case ParameterType::text:
        return json().is_string() ? made(Type::text, &ParameterValue::text, json().get<std::string>()) : wrong_type();
      case ParameterType::choice: return json().is_string() ? choice() : wrong_type();
      case ParameterType::path: return json().is_string() ? path() : wrong_type();
      case ParameterType::vector: return vector();
      case ParameterType::matrix: return matrix();
      case ParameterType::time: return time();
      case ParameterType::list: return json().is_array() ? list() : wrong_type();
      case ParameterType::map: return json().is_object() ? map() : wrong_type();
      case ParameterType::object: return json().is_object() ? members({}) : wrong_type();
    }
    return {};
  }

  ParameterValue members(const std::vector<std::string>& reserved) const {
    std::vector<std::string> known = reserved;
    RenamedKeys renamed;
    for (const ParameterSpec& member : spec.members) {
      known.push_back(member.name);
      if (!member.former_name.empty()) renamed.emplace_back(member.former_name, member.name);
    }
    std::map<std::string, std::string> detail;
    if (!std::ranges::all_of(at.children(), [&](const Reader& m) { return index_of(known, m.key()) >= 0; }))
      for (const ParameterSpec& member : spec.members)
        detail.emplace(member.name, " (" + describe_short(member, ports) + ")");
    // Saying that what was meant by an unknown key is missing as well would be noise.
    const std::set<std::string> meant = at.check_keys(known, name, renamed, detail);
    ParameterValue result;
    result.type = Type::object;
    for (const ParameterSpec& member : spec.members) {
      ParameterValue value = member_value(member, meant.contains(member.name));
      if (value.type != Type::absent) result.members.emplace_back(member.name, std::move(value));
    }
    return result;
  }

  ParameterValue member_value(const ParameterSpec& member, bool is_misspelt) const {
    const std::string label = in_quotes(member.name);
    if (const Reader place = at[member.name]) return Check{member, place, ports, label}.value();
    if (!member.default_json.empty() && !is_elsewhere(member)) {
      const Json json = Json::parse(member.default_json, nullptr, false);
      const Reader place = JsonOf::as_default(at, json);
      const Check check{member, place, ports, label};
      return json.is_discarded() ? check.error("B001", "no JSON: " + member.default_json) : check.value();
    }
    if (!member.is_required || is_misspelt) return {};
    return error("B010", "missing key " + label + " of " + name + (member.text.empty() ? "" : ": " + member.text) +
                             " (" + describe_short(member, ports) + ")" +
                             (takes_quantities(member.type) ? ", for example " + example_of(member, ports) : ""));
  }

 private:
  const Json& json() const { return JsonOf::at(at); }

  /// Nothing, as the value is then.
  ParameterValue error(const char* code, const std::string& message) const {
    at.error(code, at.is_default() ? "default of " + name + ": " + message : message);
    return {};
  }

  ParameterValue wrong_type() const {
    return error("B006", name + " must be " + expected_text(spec, ports) + "; found " + at.shown());
  }

  // -- numbers

  /// In SI, with the SI unit that it came in.
  ParameterValue number() const {
    const WantedUnit unit = wanted_unit(spec, ports);
    const std::string of_unit = unit.text == "1" || !unit.dimension ? "" : unit.text;
    ParameterValue result;
    std::string written;
    if (json().is_number()) {
      result.number = json().get<double>();
      result.text = unit.dimension ? unit.text : "1";
      written = number_text(result.number) + (of_unit.empty() ? "" : " " + of_unit);
    } else if (json().is_string()) {
      written = json().get<std::string>();
      const std::optional<Quantity> parsed = quantity(unit, written);
      if (!parsed) return {};
      result.number = parsed->value;
      result.text = unit.dimension ? unit.text : si_unit(parsed->dimension);
    } else {
      return wrong_type();
    }
    if (!std::isfinite(result.number)) return error("B009", name + " is beyond the range of a double");
    if (!in_range(spec, result.number))
      return error("B009", name + " is " + written + ", out of range (" + joined(of_unit, range_text(spec)) + ")");
    warn_if_implausible(result.number, written, of_unit);
    result.type = Type::number;
    return result;
  }

  void warn_if_implausible(double value, const std::string& written, const std::string& unit) const {
    const auto is_plausible = [&](double number) {
      return number == 0 || (std::abs(number) >= spec.least_plausible && std::abs(number) <= spec.most_plausible);
    };
    if (at.is_default() || is_plausible(value)) return;
    const auto in_unit = [&](double number) { return number_text(number, 3) + (unit.empty() ? "" : " " + unit); };
    std::string hint = "is its unit right?";
    if (json().is_number()) {
      hint = "a number without unit is SI";
      // As it would be with a usual unit of the dimension.
      ParameterSpec scalar = spec;
      scalar.type = ParameterType::number;
      scalar.default_json.clear();
      std::string meant = example_of(scalar, ports);
      std::erase(meant, '"');
      meant = number_text(value) + meant.substr(std::min(meant.find(' '), meant.size()));
      const Parsed<Quantity> quantity = parse_quantity(meant);
      if (quantity && quantity->value != value && is_plausible(quantity->value))
        hint += "; did you mean \"" + meant + "\"?";
    }
    at.warning("B111",
               name + " is " + written + (json().is_string() ? " (" + in_unit(value) + ")" : "") +
                   ", which is implausible; expected: " +
                   (spec.least_plausible > 0 ? "between " + in_unit(spec.least_plausible) + " and " : "at most ") +
                   in_unit(spec.most_plausible) + "; " + hint);
  }

  std::optional<Quantity> quantity(const WantedUnit& unit, const std::string& written) const {
    Parsed<Quantity> parsed = parse_quantity(written);
    if (spec.unit == "*") {
      const Parsed<Unit> alone = parse_unit(written);
      if (alone) return Quantity{alone->scale, alone->dimension};
      if (written.find_first_of("0123456789") == std::string::npos) parsed = Parsed<Quantity>::failure(alone.error());
    }
    if (parsed && (!unit.dimension || *unit.dimension == parsed->dimension)) return *parsed;
    if (!parsed) {
      error("B008", name + ": " + parsed.error());
      return std::nullopt;
    }
    const bool has_unit = written.find_first_not_of("+-0123456789.eE \t") != std::string::npos;
    const std::string inside = unit_and_range(spec, ports);
    error("B007", in_quotes(cut(written)) +
                      (has_unit ? " is " + bare_dimension_name(parsed->dimension) : " has no unit") + "; " + name +
                      " is " + bare_dimension_name(*unit.dimension) + (inside.empty() ? "" : " (" + inside + ")") +
                      ", for example " + scalar_example());
    return std::nullopt;
  }

  std::string scalar_example() const {
    ParameterSpec scalar = spec;
    if (scalar.type != ParameterType::time) scalar.type = ParameterType::number;
    if (spec.type != scalar.type || at.is_default()) scalar.default_json.clear();
    return example_of(scalar, ports);
  }

  ParameterValue integer() const {
    constexpr double largest = 9007199254740992.0;  // 2^53: a double beyond is no exact count
    const double as_double = json().get<double>();
    const bool is_float = json().is_number_float();
    if (is_float && (as_double != std::floor(as_double) || std::abs(as_double) > largest)) return wrong_type();
    const bool fits = !json().is_number_unsigned() || std::in_range<std::int64_t>(json().get<std::uint64_t>());
    if (!fits || !in_range(spec, as_double))
      return error("B009",
                   name + " is " + json().dump() + ", out of range (" + (fits ? range_text(spec) : "64 bits") + ")");
    return made(Type::integer, &ParameterValue::integer,
                is_float ? static_cast<std::int64_t>(as_double) : json().get<std::int64_t>());
  }

  ParameterValue time() const {
    const ParameterValue in_seconds = number();
    if (in_seconds.type == Type::absent) return {};
    if (json().is_string()) {  // once more and exactly, which a double is not
      const Parsed<std::int64_t> exact = parse_time(json().get_ref<const std::string&>());
      if (!exact) return error("B008", name + ": " + exact.error());
      return made(Type::integer, &ParameterValue::integer, *exact);
    }
    if (std::abs(in_seconds.number) > seconds(base::farthest_time))
      return error("B009", name + " is " + json().dump() + " s, beyond " + base::farthest_text);
    return made(Type::integer, &ParameterValue::integer, from_seconds(in_seconds.number));
  }

  /// Nothing where any length is right.
  std::optional<std::size_t> wanted_size(int size) const {
    if (!spec.size_of_port.empty()) {
      const std::optional<PortMeasure> measure = measure_of(ports, spec.size_of_port);
      return measure ? std::optional(as_size(measure->dof)) : std::nullopt;
    }
    return size == ParameterSpec::any_size ? std::nullopt : std::optional(as_size(size));
  }

  ParameterValue vector() const {
    const std::optional<std::size_t> size = wanted_size(spec.size);
    ParameterValue result;
    if (!json().is_array()) {
      if (!size && spec.size_of_port.empty()) return wrong_type();
      const ParameterValue all = number();
      if (all.type == Type::absent) return {};
      result.numbers.assign(size.value_or(1), all.number);
    } else {
      if (size && json().size() != *size)
        return error("B013", name + " has " + elements_text(json()) + "; it takes " + describe_short(spec, ports));
      if (!append_elements(at, result.numbers)) return {};
    }
    result.type = Type::vector;
    result.rows = base::count_of(result.numbers);
    result.cols = 1;
    return result;
  }

  /// Appends what is right; whether all are.
  bool append_elements(const Reader& row, std::vector<double>& numbers) const {
    ParameterSpec element = spec;
    element.type = ParameterType::number;
    bool all_right = true;
    for (const Reader& place : row.children()) {
      const ParameterValue value = Check{element, place, ports, name}.number();
      all_right = all_right && value.type != Type::absent;
      numbers.push_back(value.number);
    }
    return all_right;
  }

  ParameterValue matrix() const {
    if (!json().is_array() || json().empty() ||
        !std::ranges::all_of(json(), [](const Json& row) { return row.is_array(); }))
      return wrong_type();
    const std::size_t rows = json().size(), cols = json().front().size();
    const std::vector<Reader> places = at.children();
    for (const Reader& row : places)
      if (JsonOf::at(row).size() != cols)
        return Check{spec, row, ports, name}.error("B013", "row " + row.key() + " of " + name + " has " +
                                                               elements_text(JsonOf::at(row)) + ", the first has " +
                                                               std::to_string(cols));
    if (wanted_size(spec.size).value_or(rows) != rows || wanted_size(spec.cols).value_or(cols) != cols)
      return error("B013", name + " is " + std::to_string(rows) + " by " + std::to_string(cols) + "; it takes " +
                               describe_short(spec, ports));
    std::vector<double> row_major;
    bool all_right = true;
    for (const Reader& row : places) all_right = append_elements(row, row_major) && all_right;
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

  ParameterValue choice() const {
    const auto& word = json().get_ref<const std::string&>();
    if (std::ranges::find(spec.choices, word) != spec.choices.end())
      return made(Type::text, &ParameterValue::text, word);
    const std::string near = closest(word, spec.choices);
    return error("B014", name + " cannot be " + in_quotes(cut(word)) + "; " +
                             (near.empty() ? "it is one of " : "did you mean " + in_quotes(near) + "? It is one of ") +
                             quoted_list(spec.choices));
  }

  ParameterValue path() const {
    const auto& file = json().get_ref<const std::string&>();
    if (file.empty() && !at.is_default()) return wrong_type();
    const std::string scheme = file.starts_with("file:") && !file.starts_with("file://") ? "file:" : "";
    const bool is_left = file.empty() || file == "stdin:" || file == "stdout:" || file.find("://") != file.npos;
    return made(Type::text, &ParameterValue::text,
                is_left ? file : scheme + (at.folder() / file.substr(scheme.size())).lexically_normal().string());
  }

  // -- structure

  ParameterValue list() const {
    ParameterValue result;
    result.type = Type::list;
    for (const Reader& element : at.children())
      result.elements.push_back(Check{spec.members.front(), element, ports, name}.value());
    return result;
  }

  ParameterValue map() const {
    ParameterValue result;
    result.type = Type::object;
    for (const Reader& member : at.children())
      result.members.emplace_back(member.key(),
                                  Check{spec.members.front(), member, ports, in_quotes(member.key())}.value());
    return result;
  }
};

}  // namespace

// ---- specs themselves

namespace {

struct DefectSearch {
  explicit DefectSearch(const ComponentSpec& spec) : component(spec) {}

  const ComponentSpec& component;
  std::vector<std::string> defects;

  void run() {
    std::set<std::string> ports;
    for (const PortSpec& port : component.ports)
      unless(ports.insert(port.name).second, "port '" + port.name + "' appears twice");
    check_fields(component.fields);
    check_fields(component.driving_rates);
    for (const ChannelPort& input : component.inputs) check_fields(input.fields);
    check_parameters(component.parameters, true);
    if (defects.empty()) check_defaults(component.parameters);
  }

 private:
  void unless(bool is_right, const std::string& defect) {
    if (!is_right) defects.push_back(defect);
  }

  /// A unit has to be SI; `text`: with what a port stands for filled in.
  void check_unit(const std::string& who, const std::string& written, const std::string& text) {
    const Parsed<Unit> unit = parse_unit(text);
    unless(bool(unit), who + ": " + unit.error());
    unless(!unit || unit->scale == 1.0, who + ": the unit '" + written + "' is not SI");
  }

  void check_fields(const std::vector<FieldSpec>& fields) {
    std::set<std::string> names;
    for (const FieldSpec& field : fields) {
      const std::string who = "field '" + field.name + "'";
      unless(names.insert(field.name).second, who + " appears twice");
      check_unit(who, field.unit, takes_any_unit(field) ? "1" : field.unit);
    }
  }

  void check_quantity(const std::string& who, const ParameterSpec& spec) {
    if ((!takes_quantities(spec.type) && spec.unit.empty()) || spec.unit == "*") return;
    const auto has = [&](const std::string& port) { return index_of(component.ports, port, &PortSpec::name) >= 0; };
    unless(spec.size_of_port.empty() || has(spec.size_of_port),
           who + " is sized by the port '" + spec.size_of_port + "', which it lacks");
    const std::optional<std::string> port = port_of_unit(spec.unit);
    unless(!port || has(*port), who + " has the unit of the port '" + port.value_or("") + "', which it lacks");
    check_unit(who, spec.unit, port ? "(m)" + spec.unit.substr(1 + port->size()) : spec.unit.empty() ? "1" : spec.unit);
  }

  void check_parameters(const std::vector<ParameterSpec>& specs, bool are_named) {
    std::set<std::string> names;
    for (const ParameterSpec& spec : specs) {
      const std::string who = "parameter '" + spec.name + "'";
      unless(!are_named || names.insert(spec.name).second, who + " appears twice");
      unless(!are_named || !spec.name.empty(), who + " has no name");
      const bool has_element = spec.type == ParameterType::list || spec.type == ParameterType::map;
      unless(!has_element || spec.members.size() == 1, who + " needs one element spec");
      if (has_element && spec.members.size() != 1) continue;
      unless(spec.type != ParameterType::choice || !spec.choices.empty(), who + " has nothing to choose from");
      unless(!spec.is_required || spec.default_json.empty(), who + " is required and has a default");
      check_quantity(who, spec);
      check_parameters(spec.members, !has_element);
    }
  }

  /// Optional objects and lists are looked into as well: their defaults show when they are given.
  void check_defaults(const std::vector<ParameterSpec>& specs) {
    for (const ParameterSpec& spec : specs) {
      check_defaults(spec.members);
      if (spec.default_json.empty()) continue;
      Diagnostics diagnostics;
      const Reader nowhere(nothing_, diagnostics);
      if (is_elsewhere(spec))
        nowhere.parameters({spec}, spec.name);
      else
        Check{no_spec_, nowhere, no_ports_, {}}.member_value(spec, false);
      for (const Diagnostic& item : diagnostics.items()) defects.push_back(item.message);
    }
  }

  // A config without anything: every parameter has its default.
  const Document nothing_;
  const ParameterSpec no_spec_;
  const PortUnits no_ports_;
};

}  // namespace

std::vector<std::string> spec_defects(const ComponentSpec& spec) {
  DefectSearch search(spec);
  search.run();
  return std::move(search.defects);
}

// ---- kinds of blocks, part by part

namespace {

std::vector<std::string_view> parts_of(std::string_view kind) {
  std::vector<std::string_view> parts;
  for (std::size_t end = kind.find(':'); end != kind.npos; end = kind.find(':')) {
    parts.push_back(kind.substr(0, end));
    kind.remove_prefix(end + 1);
  }
  parts.push_back(kind);
  return parts;
}

bool part_matches(std::string_view pattern, std::string_view part) {
  if (pattern == "*" || pattern == part) return true;
  const Parsed<Unit> wanted = parse_unit(pattern);
  const Parsed<Unit> had = parse_unit(part);
  return wanted && had && wanted->dimension == had->dimension;
}

}  // namespace

bool kind_matches(std::string_view pattern, std::string_view kind) {
  if (pattern == "*") return true;
  const std::vector<std::string_view> wanted = parts_of(pattern);
  const std::vector<std::string_view> had = parts_of(kind);
  if (wanted.size() != had.size()) return false;
  const bool first_matches = wanted.front() == "*" || wanted.front() == had.front();
  return first_matches && std::equal(wanted.begin() + 1, wanted.end(), had.begin() + 1, part_matches);
}

Parsed<std::string> canonical_kind(std::string_view kind) {
  const std::vector<std::string_view> parts = parts_of(kind);
  std::string canonical(parts.front());
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const Parsed<Unit> unit = parse_unit(parts[i]);
    const std::string si = unit ? si_unit(unit->dimension) : std::string(parts[i]);
    if (unit && unit->scale != 1.0)
      return Parsed<std::string>::failure("a block's values are SI, so its unit cannot be " + in_quotes(parts[i]) +
                                          "; write " + in_quotes(si));
    canonical += ":" + si;
  }
  return canonical;
}

}  // namespace binnacle::internal::spec

namespace binnacle {

using namespace internal;

std::string Reader::shown() const {
  using Json = spec::Json;
  const Json& value = config::JsonOf::at(*this);
  switch (value.type()) {
    case Json::value_t::string: return "the text \"" + spec::cut(value.get_ref<const std::string&>()) + "\"";
    case Json::value_t::object: return value.empty() ? "an empty object" : "an object";
    case Json::value_t::array: return value.empty() ? "an empty list" : "a list of " + std::to_string(value.size());
    case Json::value_t::number_integer:
    case Json::value_t::number_unsigned:
    case Json::value_t::number_float: return "the number " + spec::cut(value.dump());
    default: return value.dump();
  }
}

ParameterValue Reader::value(const ParameterSpec& spec, const PortUnits& ports) const {
  return json_ ? spec::Check{spec, *this, ports, base::in_quotes(spec.name)}.value() : ParameterValue();
}

ParameterValue Reader::parameters(const std::vector<ParameterSpec>& specs, const std::string& type_name,
                                  const std::vector<std::string>& reserved, const PortUnits& ports) const {
  const std::string name = base::in_quotes(type_name);
  if (json_ && !is_object(name)) return {};
  ParameterValue all = spec::Check{parameter::object(type_name, specs), *this, ports, name}.members(reserved);
  for (const ParameterSpec& each : specs) {
    if (!spec::is_elsewhere(each) || (*this)[each.name]) continue;
    Diagnostics found;
    ParameterValue value = Reader(*document_, found, each.default_json).value(each, ports);
    diagnostics_->merge(found);
    if (found.has_errors())
      error("B010", base::in_quotes(each.name) + " of " + name +
                        " is that of the config, in which something is wrong (" + each.default_json + ")");
    else if (value.type != ParameterValue::Type::absent)
      all.members.emplace_back(each.name, std::move(value));
  }
  return all;
}

}  // namespace binnacle
