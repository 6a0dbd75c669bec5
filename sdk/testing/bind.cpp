// SPDX-License-Identifier: Apache-2.0
#include "binnacle/bind.hpp"

#include <algorithm>
#include <stdexcept>

#include "binnacle/catalog.hpp"
#include "binnacle/composition.hpp"
#include "binnacle/section.hpp"

namespace binnacle::testing {

namespace {

constexpr const char* section_name = "component";

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// A section that is one component's parameters, in a config that has nothing else.
class ParametersSection final : public Section {
 public:
  ParametersSection(const ComponentSpec& spec, const Setup& setup) : spec_(spec), setup_(setup) {}
  std::vector<std::string> keys() const override { return {section_name}; }
  std::shared_ptr<const SectionData> read(CompositionDraft& draft) const override {
    value_ = draft.at(std::string("/") + section_name).parameters(spec_.parameters, spec_.type, {}, measures());
    return nullptr;
  }
  ParameterValue take() const { return std::move(value_); }

 private:
  /// Blocks whose error components are of one unit, as the kernel reads them.
  PortUnits measures() const {
    PortUnits measures;
    for (const auto& [port, block] : setup_.ports) {
      const auto& error = block->declaration().error;
      const auto is_like_first = [&](const NamedUnit& component) { return component.unit == error.front().unit; };
      if (error.empty() || !std::all_of(error.begin(), error.end(), is_like_first)) continue;
      if (const auto unit = parse_unit(error.front().unit))
        measures.emplace(port, PortMeasure{unit->dimension, static_cast<int>(error.size())});
    }
    return measures;
  }

  const ComponentSpec& spec_;
  const Setup& setup_;
  mutable ParameterValue value_;
};

std::vector<PortBinding> port_bindings(const ComponentSpec& spec, const Setup& setup) {
  std::vector<PortBinding> bindings;
  for (const PortSpec& port : spec.ports) {
    PortBinding& binding = bindings.emplace_back();
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
  }
  for (const auto& [name, block] : setup.ports)
    if (std::none_of(spec.ports.begin(), spec.ports.end(), [&, &name = name](const auto& p) { return p.name == name; }))
      throw std::logic_error("the test plugs in port '" + name + "', which is not declared");
  return bindings;
}

BindingParts parts_of(const ComponentSpec& spec, const Setup& setup, const ParameterValue& parameters) {
  BindingParts parts{.name = setup.name, .parameters = Parameters(parameters)};
  parts.ports = port_bindings(spec, setup);
  const auto add_fields = [&](const std::vector<FieldSpec>& fields) {
    for (const FieldSpec& field : fields) parts.fields_bound.push_back(!contains(setup.without, field.name));
  };
  add_fields(spec.fields);
  for (const ChannelPort& input : spec.inputs) add_fields(input.fields);
  for (const ChannelPort& input : spec.inputs) {
    parts.inputs_bound.push_back(!contains(setup.without, input.name));
    const auto channel = setup.channels.find(input.name);
    parts.channels.push_back(channel == setup.channels.end() ? nullptr : channel->second);
  }
  parts.samples_per_step = setup.samples_per_step;
  parts.covariances.resize(std::max<std::size_t>(1, spec.inputs.size()));
  parts.covariances.front() = setup.covariance;
  parts.spec = &spec;
  parts.has_driving_rates = true;
  parts.findings = setup.findings;
  return parts;
}

/// All messages, at the place of the first.
ComponentError as_component_error(const Diagnostics& found) {
  const std::string prefix = std::string("/") + section_name;
  std::string messages, pointer;
  for (const Diagnostic& item : found.sorted()) {
    if (item.severity != Severity::error) continue;
    if (messages.empty())
      pointer = item.pointer.starts_with(prefix) ? item.pointer.substr(prefix.size()) : item.pointer;
    messages += (messages.empty() ? "" : "; ") + item.message;
  }
  return ComponentError(messages, pointer);
}

}  // namespace

ParameterValue read_parameters(const ComponentSpec& spec, const Setup& setup) {
  const auto section = std::make_shared<ParametersSection>(spec, setup);
  LoadOptions options;
  options.sections = {section};
  options.plugin_folders = {"/dev/null"};  // none is searched
  const std::string config =
      std::string(R"({"binnacle": 1, "filters": {}, ")") + section_name + "\": " + setup.parameters.text() + "}";
  try {
    Composition::parse(config, setup.name + ".json", options);
  } catch (const Error& refused) {
    throw as_component_error(refused.diagnostics());
  }
  return section->take();
}

BoundTo::BoundTo(const ComponentSpec& spec, const Setup& setup)
    : parameters_(read_parameters(spec, setup)), binding_(parts_of(spec, setup, parameters_)) {}

Catalog types_of(std::function<void(Registry&)> add_types) {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.add(std::make_shared<const LinkedPlugin>(LinkedPlugin{"tested", "1.0.0", std::move(add_types)}), diagnostics);
  if (diagnostics.has_errors()) throw LoadError(diagnostics);
  return catalog;
}

const ComponentType& type_of(const Catalog& catalog, Role role, std::string_view name) {
  if (const ComponentType* type = catalog.find(role, name)) return *type;
  throw std::out_of_range("there is no " + std::string(role_name(role)) + " '" + std::string(name) + "'");
}

}  // namespace binnacle::testing
