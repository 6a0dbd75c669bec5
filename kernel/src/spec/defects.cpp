// SPDX-License-Identifier: Apache-2.0
// What a component's author got wrong in its spec.
#include <algorithm>

#include "base/index.hpp"
#include "base/text.hpp"
#include "spec/check.hpp"
#include "spec/spec_text.hpp"

namespace binnacle::spec {

namespace {

class DefectSearch {
 public:
  explicit DefectSearch(const ComponentSpec& component) : component_(component) {}

  std::vector<std::string> run() {
    std::set<std::string> ports;
    for (const PortSpec& port : component_.ports)
      unless(ports.insert(port.name).second, "port '" + port.name + "' stands twice");
    check_fields(component_.fields);
    check_fields(component_.driving_rates);
    for (const ChannelPort& input : component_.inputs) check_fields(input.fields);
    check_parameters(component_.parameters, true);
    if (defects_.empty()) check_defaults(component_.parameters);
    return std::move(defects_);
  }

 private:
  void unless(bool is_right, const std::string& defect) {
    if (!is_right) defects_.push_back(defect);
  }

  /// A unit has to be SI; `text`: with what a port stands for filled in.
  void check_unit(const std::string& who, const std::string& written, const std::string& text) {
    const Parsed<Unit> unit = read_unit(text);
    unless(bool(unit), who + ": " + unit.error());
    unless(!unit || unit->scale == 1.0, who + ": the unit '" + written + "' is not SI");
  }

  void check_fields(const std::vector<FieldSpec>& fields) {
    std::set<std::string> names;
    for (const FieldSpec& field : fields) {
      const std::string who = "field '" + field.name + "'";
      unless(names.insert(field.name).second, who + " stands twice");
      check_unit(who, field.unit, takes_any_unit(field) ? "1" : field.unit);
    }
  }

  void check_quantity(const std::string& who, const ParameterSpec& spec) {
    if ((!takes_quantities(spec.type) && spec.unit.empty()) || spec.unit == "*") return;
    const auto has = [&](const std::string& port) {
      return base::index_of(component_.ports, port, &PortSpec::name) >= 0;
    };
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
      unless(!are_named || names.insert(spec.name).second, who + " stands twice");
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
      ParameterSpec named = spec;
      named.is_required = false;
      const Document empty;
      Diagnostics diagnostics;
      Reader(empty, diagnostics).parameters({named}, spec.name);
      for (const Diagnostic& item : diagnostics.items()) defects_.push_back(item.message);
    }
  }

  const ComponentSpec& component_;
  std::vector<std::string> defects_;
};

}  // namespace

std::vector<std::string> spec_defects(const ComponentSpec& spec) { return DefectSearch(spec).run(); }

}  // namespace binnacle::spec
