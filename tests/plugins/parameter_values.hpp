// SPDX-License-Identifier: Apache-2.0
// Checked parameters written by hand, for tests that construct a component without the kernel's config.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::parameter_values {

inline ParameterValue boolean(bool value) {
  ParameterValue v;
  v.type = ParameterValue::Type::boolean;
  v.boolean = value;
  return v;
}
inline ParameterValue number(double value, std::string si_unit = {}) {
  ParameterValue v;
  v.type = ParameterValue::Type::number;
  v.number = value;
  v.text = std::move(si_unit);
  return v;
}
/// A unit as parameter::number(…, "*") delivers it.
inline ParameterValue unit(std::string si, double factor = 1) { return number(factor, std::move(si)); }
inline ParameterValue text(std::string value) {
  ParameterValue v;
  v.type = ParameterValue::Type::text;
  v.text = std::move(value);
  return v;
}
inline ParameterValue instant(double s) {
  ParameterValue v;
  v.type = ParameterValue::Type::integer;
  v.integer = nanoseconds(s);
  return v;
}
inline ParameterValue list(std::vector<ParameterValue> elements) {
  ParameterValue v;
  v.type = ParameterValue::Type::list;
  v.elements = std::move(elements);
  return v;
}
inline ParameterValue object(std::vector<std::pair<std::string, ParameterValue>> members) {
  ParameterValue v;
  v.type = ParameterValue::Type::object;
  v.members = std::move(members);
  return v;
}

/// `value` with member `name` set, replaced where it was.
inline ParameterValue with(ParameterValue value, const std::string& name, ParameterValue member) {
  for (auto& [key, present] : value.members)
    if (key == name) {
      present = std::move(member);
      return value;
    }
  value.members.emplace_back(name, std::move(member));
  return value;
}

/// With the handles of Component's inputs, all bound.
template <class Component>
Binding bind_as(const ParameterValue& parameters) {
  static const ComponentSpec spec = Component::spec();
  std::size_t fields = spec.fields.size();
  for (const ChannelPort& input : spec.inputs) fields += input.fields.size();
  return Binding({.name = "tested",
                  .parameters = Parameters(parameters),
                  .fields_bound = std::vector<bool>(fields, true),
                  .spec = &spec,
                  .inputs_bound = std::vector<bool>(spec.inputs.size(), true)});
}

inline Binding bind(const ParameterValue& parameters, std::string name = "tested") {
  return Binding({std::move(name), Parameters(parameters)});
}

/// Everything in a spec that documentation needs is there, down to nested parameters.
inline std::string undocumented(const std::vector<ParameterSpec>& parameters, const std::string& where = {}) {
  for (const auto& parameter : parameters) {
    const std::string pointer = where + "/" + parameter.name;
    if (parameter.name.empty() || (parameter.text.empty() && where.empty())) return pointer;
    const bool is_element = parameter.type == ParameterType::map || parameter.type == ParameterType::list;
    if (!is_element)
      for (const auto& member : parameter.members)
        if (member.text.empty()) return pointer + "/" + member.name;
    for (const auto& member : parameter.members)
      if (const auto missing = undocumented(member.members, pointer + "/" + member.name); !missing.empty())
        return missing;
  }
  return {};
}

}  // namespace binnacle::parameter_values
