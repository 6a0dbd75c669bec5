// SPDX-License-Identifier: Apache-2.0
// Binds a component for a test: parameters from JSON in SI numbers, ports from state blocks.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/binding.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"
#include "binnacle/unit.hpp"

namespace binnacle::test {

/// Which state block each port is plugged into; a port that is not named stays open.
using Ports = std::map<std::string, const StateBlock*>;

/// What a component is bound to. `without`: optional fields that the channel lacks, inputs that stay open.
struct Setup {
  nlohmann::json parameters = nlohmann::json::object();
  Ports ports;
  std::vector<std::string> without;
  int samples_per_step = 1;
  std::vector<NamedUnit> covariance = {};  // of the channel
  std::vector<std::string> frozen = {};    // ports none of whose components is estimated
};

inline bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

namespace detail {

using Json = nlohmann::json;

inline int dof_of(const Setup& setup, const std::string& port) {
  const auto found = setup.ports.find(port);
  return found == setup.ports.end() ? 0 : found->second->declaration().dof();
}

/// Defaults are written as a config writes them: "10 deg".
inline double quantity(const Json& json) {
  return json.is_string() ? parse_quantity(json.get<std::string>())->value : json.get<double>();
}

inline std::vector<double> numbers(const Json& json, int size) {
  if (json.is_array()) return json.get<std::vector<double>>();
  if (size < 0) throw std::logic_error("one number for a vector whose size nobody knows: the kernel wants a list");
  return std::vector<double>(static_cast<std::size_t>(size), quantity(json));
}

inline ParameterValue object_value(const std::vector<ParameterSpec>& specs, const Json& json, const Setup& setup);

inline ParameterValue value(const ParameterSpec& spec, const Json& json, const Setup& setup) {
  using Type = ParameterValue::Type;
  ParameterValue v;
  const int size = spec.size_of_port.empty() ? spec.size : dof_of(setup, spec.size_of_port);
  switch (spec.type) {
    case ParameterType::number:
      v.type = Type::number;
      if (spec.unit == "*" && json.is_string()) {
        const Unit unit = *parse_unit(json.get<std::string>());
        v.number = unit.scale, v.text = si_unit(unit.dimension);
      } else {
        v.number = quantity(json);
        v.text = spec.unit == "*" ? "1" : spec.unit;
      }
      break;
    case ParameterType::integer: v.type = Type::integer, v.integer = json.get<std::int64_t>(); break;
    case ParameterType::time: v.type = Type::integer, v.integer = nanoseconds(quantity(json)); break;
    case ParameterType::boolean: v.type = Type::boolean, v.boolean = json.get<bool>(); break;
    case ParameterType::text:
    case ParameterType::choice:
    case ParameterType::path: v.type = Type::text, v.text = json.get<std::string>(); break;
    case ParameterType::vector:
      v.type = Type::vector, v.numbers = numbers(json, size), v.rows = static_cast<int>(v.numbers.size()), v.cols = 1;
      break;
    case ParameterType::matrix:
      v.type = Type::matrix, v.rows = static_cast<int>(json.size()), v.cols = static_cast<int>(json.at(0).size());
      for (std::size_t j = 0; j < json.at(0).size(); ++j)
        for (const auto& row : json) v.numbers.push_back(row.at(j).get<double>());
      break;
    case ParameterType::list:
      v.type = Type::list;
      for (const auto& element : json) v.elements.push_back(value(spec.members.front(), element, setup));
      break;
    case ParameterType::map:
      v.type = Type::object;
      for (const auto& [key, element] : json.items())
        v.members.emplace_back(key, value(spec.members.front(), element, setup));
      break;
    case ParameterType::object: v = object_value(spec.members, json, setup); break;
  }
  return v;
}

inline ParameterValue object_value(const std::vector<ParameterSpec>& specs, const Json& json, const Setup& setup) {
  ParameterValue v;
  v.type = ParameterValue::Type::object;
  for (const ParameterSpec& spec : specs) {
    if (json.contains(spec.name)) {
      v.members.emplace_back(spec.name, value(spec, json.at(spec.name), setup));
    } else if (!spec.default_json.empty() && spec.default_json[0] != '/') {
      v.members.emplace_back(spec.name, value(spec, Json::parse(spec.default_json), setup));
    } else if (spec.is_required) {
      throw std::logic_error("the test gives no '" + spec.name + "'");
    }
  }
  for (const auto& [key, unused] : json.items())
    if (std::none_of(specs.begin(), specs.end(),
                     [&, &key = key](const ParameterSpec& spec) { return spec.name == key; }))
      throw std::logic_error("the test gives '" + key + "', which is not declared");
  return v;
}

inline std::vector<PortBinding> port_bindings(const ComponentSpec& spec, const Setup& setup) {
  std::vector<PortBinding> bindings;
  for (const PortSpec& port : spec.ports) {
    PortBinding binding;
    binding.name = port.name;
    if (const auto found = setup.ports.find(port.name); found != setup.ports.end()) {
      const StateBlockDeclaration& block = found->second->declaration();
      binding.bound = true;
      binding.kind = block.kind;
      binding.dof = block.dof();
      binding.stored_size = block.stored_size;
      binding.components = block.error;
      binding.is_estimated = !contains(setup.frozen, port.name);
    } else if (!port.is_optional) {
      throw std::logic_error("the test leaves port '" + port.name + "' open");
    }
    bindings.push_back(std::move(binding));
  }
  return bindings;
}

inline std::vector<bool> fields_bound(const ComponentSpec& spec, const Setup& setup) {
  std::vector<bool> bound;
  const auto add = [&](const std::vector<FieldSpec>& fields) {
    for (const FieldSpec& field : fields) bound.push_back(!contains(setup.without, field.name));
  };
  add(spec.fields);
  for (const ChannelPort& input : spec.inputs) add(input.fields);
  return bound;
}

}  // namespace detail

/// As the kernel does it: `new Component(binding)`, the binding gone afterwards.
template <class Component>
std::unique_ptr<Component> bind(const Setup& setup = {}) {
  const ComponentSpec spec = Component::spec();
  const ParameterValue parameters = detail::object_value(spec.parameters, setup.parameters, setup);
  std::vector<bool> inputs_bound;
  for (const ChannelPort& input : spec.inputs) inputs_bound.push_back(!contains(setup.without, input.name));
  return std::make_unique<Component>(Binding({.name = "under_test",
                                              .parameters = Parameters(parameters),
                                              .ports = detail::port_bindings(spec, setup),
                                              .fields_bound = detail::fields_bound(spec, setup),
                                              .samples_per_step = setup.samples_per_step,
                                              .covariances = {setup.covariance},
                                              .spec = &spec,
                                              .inputs_bound = inputs_bound,
                                              .has_driving_rates = true}));
}

}  // namespace binnacle::test
