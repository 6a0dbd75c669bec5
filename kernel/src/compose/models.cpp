// SPDX-License-Identifier: Apache-2.0
// Ports, derived blocks and process models of a filter.
#include <algorithm>

#include "compose/composer.hpp"

#include "base/index.hpp"

namespace binnacle::compose {

using base::as_size;

namespace {

/// "; a constant is {…}": by the type that moves blocks of any kind and asks for nothing, if one is loaded.
std::string constant_hint(const Catalog& catalog, const std::string& block) {
  for (const ComponentType* type : catalog.types()) {
    const ComponentSpec& spec = type->spec;
    if (type->role != Role::process_model || spec.ports.size() != 1 || spec.ports.front().kind != "*") continue;
    if (!spec.parameters.empty() || !spec.fields.empty()) continue;
    return "; a constant is {\"type\": \"" + spec.type + "\", \"blocks\": {\"" + spec.ports.front().name + "\": \"" +
           block + "\"}}";
  }
  return {};
}

}  // namespace

void Composer::finish_filters() {
  for (auto& build : builds_) {
    const std::size_t errors = error_count();
    for (auto& block : build.plan.blocks) {
      read_initial(build, block, block.pointer);
      read_sigma(build, block, block.pointer);
    }
    find_input(build);
    add_derived(build);
    add_processes(build);
    add_measurements(build);
    if (error_count() != errors) build.is_complete = false;
    if (build.is_complete) plan_transition(build);
  }
}

void Composer::check_port_names(const ComponentSpec& spec, const std::string& blocks_pointer) {
  const auto* blocks = object_at(document(), blocks_pointer, "'blocks'", diagnostics_);
  if (!blocks) return;
  const auto names = names_of(spec.ports);
  for (const auto& item : blocks->items()) {
    const std::string& key = item.key();
    if (std::find(names.begin(), names.end(), key) != names.end()) continue;
    const auto renamed = std::find_if(spec.ports.begin(), spec.ports.end(),
                                      [&](const PortSpec& port) { return port.former_name == key; });
    key_error("B012", join_pointer(blocks_pointer, key),
              "'" + spec.type + "' has no port '" + key + "'" +
                  (renamed != spec.ports.end() ? "; it is now called '" + renamed->name + "'"
                                               : suggestion(key, names)) +
                  " (ports: " + listed(names) + ")");
  }
}

bool Composer::bind_port(const FilterBuild& build, const PortSpec& port, const std::string& type,
                         const std::string& pointer, int& value, PortBinding& binding) {
  const auto name = read_string(document(), pointer, diagnostics_);
  if (!name || build.failed_values.contains(*name)) return false;
  value = build.value(*name);
  if (value < 0) {
    const auto names = names_of(build.values);
    error("B015", pointer,
          "there is no block '" + *name + "'" + suggestion(*name, names) + " (blocks: " + listed(names) + ")");
    return true;
  }
  const auto& info = build.values[as_size(value)];
  if (!kind_matches(port.kind, info.kind)) {
    error("B016", pointer,
          "port '" + port.name + "' of '" + type + "' takes a block of kind '" + port.kind + "'; '" + *name +
              "' is of kind '" + info.kind + "'");
  } else if (info.is_derived && port.access == PortAccess::advances) {
    error("B016", pointer,
          "port '" + port.name + "' of '" + type + "' advances its block; '" + *name +
              "' is derived and follows from others");
  } else {
    binding.bound = true;
    binding.kind = info.kind;
    binding.dof = info.dof;
    binding.stored_size = info.stored_size;
    binding.components = info.components;
  }
  return true;
}

bool Composer::bind_ports(FilterBuild& build, const ComponentType& type, const std::string& pointer,
                          std::vector<int>& ports, std::vector<PortBinding>& bindings) {
  const auto& spec = type.spec;
  const std::size_t errors = error_count();
  bool is_whole = true;
  const std::string blocks_pointer = join_pointer(pointer, "blocks");
  check_port_names(spec, blocks_pointer);
  for (const auto& port : spec.ports) {
    PortBinding binding;
    binding.name = port.name;
    int value = -1;
    const std::string port_pointer = join_pointer(blocks_pointer, port.name);
    if (at(port_pointer)) {
      is_whole = bind_port(build, port, spec.type, port_pointer, value, binding) && is_whole;
    } else if (!port.is_optional) {
      std::vector<std::string> fitting;
      for (const auto& info : build.values)
        if (kind_matches(port.kind, info.kind)) fitting.push_back(info.name);
      key_error("B017", pointer,
                "port '" + port.name + "' of '" + spec.type + "' is not bound (kind '" + port.kind +
                    "'): \"blocks\": {\"" + port.name + "\": \"" +
                    (fitting.empty() ? std::string("…") : fitting.front()) + "\"}");
    }
    ports.push_back(binding.bound ? value : -1);
    bindings.push_back(std::move(binding));
  }
  if (!is_whole) build.is_complete = false;
  return is_whole && error_count() == errors;
}

PortUnits Composer::port_units(const std::vector<PortBinding>& bindings) const {
  return [&bindings](std::string_view port) -> std::optional<PortMeasure> {
    for (const auto& binding : bindings) {
      if (binding.name != port || !binding.bound || binding.components.empty()) continue;
      const auto unit = parse_unit(binding.components.front().unit);
      for (const auto& component : binding.components)
        if (component.unit != binding.components.front().unit) return std::nullopt;
      if (unit) return PortMeasure{unit->dimension, binding.dof};
    }
    return std::nullopt;
  };
}

void Composer::find_input(FilterBuild& build) {
  const std::string pointer = join_pointer(build.pointer, "process");
  const auto* processes = object_at(document(), pointer, "'process'", diagnostics_);
  if (!processes) return;
  std::string first, first_pointer;
  for (const auto& [name, value] : processes->items()) {
    const std::string input_pointer = join_pointer(join_pointer(pointer, name), "input");
    if (!at(input_pointer)) continue;
    const auto channel = read_string(document(), input_pointer, diagnostics_);
    if (!channel) continue;
    if (!first.empty() && *channel != first) {
      error("B020", input_pointer,
            "filter '" + build.plan.name + "' is driven by channel '" + first + "' already (" + first_pointer +
                "); a filter has at most one driving input");
      continue;
    }
    if (!first.empty()) continue;
    first = *channel;
    first_pointer = input_pointer;
    bool is_told = false;
    build.plan.input_channel = channel_named(*channel, input_pointer, is_told);
    if (build.plan.input_channel < 0) build.is_complete = false;
  }
  if (build.plan.input_channel < 0) return;
  const auto& channel = plan_->channels[as_size(build.plan.input_channel)];
  build.plan.input_fields = channel.epoch_fields;
  build.plan.input_used.assign(as_size(channel.epoch_fields), 0);
  for (const auto& field : channel.declaration.fields)
    if (!field.is_per_row) build.plan.input_kinds.push_back(field.kind);
}

bool Composer::find_driving_rates(FilterBuild& build, const ComponentType& type, const std::string& pointer,
                                  std::vector<int>& driving_rates) {
  if (type.spec.driving_rates.empty()) return true;
  if (build.plan.input_channel < 0) {
    const bool all_optional = std::all_of(type.spec.driving_rates.begin(), type.spec.driving_rates.end(),
                                          [](const FieldSpec& field) { return field.is_optional; });
    if (!all_optional && build.is_complete)
      error("B021", pointer, "'" + type.spec.type + "' needs the rates of the filter's driving input, which has none");
    return all_optional;
  }
  const auto& channel = plan_->channels[as_size(build.plan.input_channel)];
  const std::size_t errors = error_count();
  for (const auto& wanted : type.spec.driving_rates) {
    int index = -1;
    for (std::size_t i = 0; i < channel.declaration.fields.size(); ++i)
      if (channel.declaration.fields[i].name == wanted.name) index = channel.position[i];
    if (index < 0 && !wanted.is_optional)
      error("B021", pointer,
            "the driving input '" + channel.name + "' has no field '" + wanted.name + "' that '" + type.spec.type +
                "' needs");
    if (index < 0) continue;
    driving_rates.push_back(index);
    build.plan.input_used[as_size(index)] = 1;
  }
  if (driving_rates.size() != type.spec.driving_rates.size()) driving_rates.clear();
  return error_count() == errors;
}

bool Composer::read_auxiliary(FilterBuild& build, AuxiliaryPlan& auxiliary, const std::string& pointer,
                              const ComponentSpec& spec, std::vector<bool>& fields_bound,
                              std::vector<bool>& inputs_bound) {
  if (spec.inputs.empty()) return true;
  std::vector<NodeInput> inputs;
  const bool is_whole = read_inputs(spec, pointer, true, inputs);
  auto& kept = build.plan.auxiliary;
  for (auto& input : inputs) {
    int index = -1;
    if (input.channel >= 0) {
      for (std::size_t i = 0; i < kept.size(); ++i)
        if (kept[i].channel == input.channel) index = static_cast<int>(i);
      if (index < 0) {
        index = static_cast<int>(kept.size());
        kept.push_back(LatestPlan{input.channel, 0, {}, {}, {}});
      }
    }
    auxiliary.channels.push_back(index);
    inputs_bound.push_back(index >= 0);
    const auto first = fields_bound.size();
    fields_bound.resize(first + spec.inputs[inputs_bound.size() - 1].fields.size(), false);
    for (const auto* items : {&input.fields.epoch, &input.fields.row})
      for (const auto& item : *items) fields_bound[first + as_size(item.declared)] = item.index >= 0;
    auxiliary.fields.push_back(std::move(input.fields));
  }
  return is_whole;
}

bool Composer::create_derived(FilterBuild& build, DerivedPlan& plan) {
  const std::size_t errors = error_count();
  const ComponentType* type = type_of(Role::derived_block, plan.pointer);
  if (!type) return false;
  std::vector<PortBinding> bindings;
  plan.type = type->full_name();
  const bool is_bound = bind_ports(build, *type, plan.pointer, plan.ports, bindings);
  const auto parameters = check_parameters(type->spec.parameters, type->spec.type, document(), plan.pointer,
                                           {"type", "blocks"}, port_units(bindings), diagnostics_);
  const bool has_rates = find_driving_rates(build, *type, plan.pointer, plan.driving_rates);
  if (!is_bound || !has_rates || error_count() != errors) return false;
  guarded(plan.pointer, [&](Findings& findings) {
    plan.derived = type->create_derived_block(Binding(plan.name, Parameters(parameters), bindings, {})
                                                  .of(type->spec, {}, !plan.driving_rates.empty())
                                                  .telling(findings));
  });
  if (!plan.derived) return false;
  for (const int port : plan.derived->declaration().read_ports)
    if (port < 0 || as_size(port) >= plan.ports.size() || plan.ports[as_size(port)] < 0) {
      error("B030", plan.pointer, "'" + type->spec.type + "' declares a Jacobian for a port that is not bound");
      return false;
    }
  return true;
}

bool Composer::add_derived_block(FilterBuild& build, const std::string& name, const std::string& pointer) {
  DerivedPlan plan;
  plan.name = name;
  plan.pointer = pointer;
  if (!create_derived(build, plan)) return false;
  const auto& declaration = plan.derived->declaration();
  const int dof = plan.dof();
  plan.value = build.reserve(as_size(declaration.stored_size));
  std::set<int> blocks;
  for (const int port : declaration.read_ports) {
    const int value = plan.ports[as_size(port)];
    const int columns = build.values[as_size(value)].dof;
    plan.reads.push_back({value, build.reserve(as_size(dof * columns)), port});
    if (value < static_cast<int>(build.plan.blocks.size())) {
      blocks.insert(value);
    } else {
      for (const auto& dependence : build.plan.derived[as_size(value) - build.plan.blocks.size()].dependences)
        blocks.insert(dependence.block);
    }
  }
  for (const int block : blocks)
    plan.dependences.push_back({block, build.reserve(as_size(dof * build.values[as_size(block)].dof))});
  const auto kind = canonical_kind(declaration.kind);
  if (!kind) error("B030", pointer, kind.error());
  build.values.push_back(
      {name, kind ? *kind : declaration.kind, dof, declaration.stored_size, declaration.error, true});
  build.plan.derived.push_back(std::move(plan));
  return true;
}

void Composer::add_derived(FilterBuild& build) {
  const std::string section = join_pointer(build.pointer, "derived");
  const auto* derived = object_at(document(), section, "'derived'", diagnostics_);
  if (!derived) return;
  std::vector<std::string> waiting;
  for (const auto& item : derived->items()) {
    const std::string& name = item.key();
    waiting.push_back(name);
    if (build.value(name) >= 0 || build.failed_values.contains(name))
      key_error("B002", join_pointer(section, name), "a block is called '" + name + "' already");
  }
  const auto is_pending = [&](const std::string& name) {
    const auto* blocks = at(join_pointer(join_pointer(section, name), "blocks"));
    if (!blocks || !blocks->is_object()) return false;
    return std::any_of(blocks->begin(), blocks->end(), [&](const auto& value) {
      return value.is_string() && build.value(value.template get<std::string>()) < 0 &&
             std::find(waiting.begin(), waiting.end(), value.template get<std::string>()) != waiting.end();
    });
  };
  while (!waiting.empty()) {
    std::vector<std::string> later;
    for (const auto& name : waiting) {
      if (is_pending(name)) {
        later.push_back(name);
      } else if (!add_derived_block(build, name, join_pointer(section, name))) {
        build.failed_values.insert(name);
        build.is_complete = false;
      }
    }
    if (later.size() == waiting.size()) {
      error("B023", join_pointer(section, later.front()), "these derived blocks need each other: " + listed(later));
      for (const auto& name : later) build.failed_values.insert(name);
      build.is_complete = false;
      return;
    }
    waiting = later;
  }
}

std::vector<int> Composer::derived_closure(const FilterBuild& build, const std::vector<int>& values) const {
  const int blocks = static_cast<int>(build.plan.blocks.size());
  std::set<int> needed;
  std::vector<int> open = values;
  while (!open.empty()) {
    const int value = open.back();
    open.pop_back();
    if (value < blocks || !needed.insert(value).second) continue;
    for (const int port : build.plan.derived[as_size(value - blocks)].ports) open.push_back(port);
  }
  return {needed.begin(), needed.end()};
}

bool Composer::read_process_input(FilterBuild& build, ProcessPlan& plan, const ComponentSpec& spec,
                                  std::vector<bool>& fields_bound, int& samples_per_step) {
  const std::string input_pointer = join_pointer(plan.pointer, "input");
  plan.uses_input = !spec.fields.empty();
  if (!plan.uses_input) {
    if (at(input_pointer)) key_error("B012", input_pointer, "'" + spec.type + "' takes no input");
    return true;
  }
  bool is_whole = true;
  if (!at(input_pointer))
    key_error("B010", plan.pointer, "'input' of '" + spec.type + "' is missing (name of a channel)");
  else if (build.plan.input_channel < 0)
    is_whole = false;
  else if (map_fields(spec.fields, build.plan.input_channel, plan.pointer, input_pointer, spec.type, plan.fields,
                      mappable_fields(spec)))
    for (const auto& item : plan.fields.epoch) {
      fields_bound[as_size(item.declared)] = item.index >= 0;
      if (item.index >= 0) build.plan.input_used[as_size(item.index)] = 1;
    }
  const std::string samples_pointer = join_pointer(plan.pointer, "samples_per_step");
  if (at(samples_pointer)) {
    auto range = parameter::integer("samples_per_step");
    range.minimum = 1;
    range.maximum = 16;
    if (const auto samples = read_integer(document(), samples_pointer, range, diagnostics_))
      samples_per_step = static_cast<int>(*samples);
    build.plan.samples_per_step = std::max(build.plan.samples_per_step, samples_per_step);
  }
  return is_whole;
}

bool Composer::check_couplings(const ProcessPlan& plan, const ComponentSpec& spec,
                               const std::vector<PortBinding>& bindings) {
  const auto is_bound = [&](int port) {
    return port >= 0 && as_size(port) < plan.ports.size() && plan.ports[as_size(port)] >= 0;
  };
  const auto is_advanced = [&](int port) { return spec.ports[as_size(port)].access == PortAccess::advances; };
  const auto is_sound = [&](const Coupling& coupling, bool is_noise) {
    return is_bound(coupling.to) && is_bound(coupling.from) && is_advanced(coupling.to) &&
           (!is_noise || is_advanced(coupling.from)) &&
           (coupling.structure == Structure::dense ||
            bindings[as_size(coupling.to)].dof == bindings[as_size(coupling.from)].dof);
  };
  const auto& declared = plan.model->declaration();
  const bool all_are_sound = std::all_of(declared.transition.begin(), declared.transition.end(),
                                         [&](const Coupling& coupling) { return is_sound(coupling, false); }) &&
                             std::all_of(declared.noise.begin(), declared.noise.end(),
                                         [&](const Coupling& coupling) { return is_sound(coupling, true); });
  if (!all_are_sound)
    error("B030", plan.pointer,
          "'" + spec.type + "' declares a coupling of ports that are open, not advanced, or of unequal dof");
  return all_are_sound;
}

void Composer::advance_blocks(FilterBuild& build, const ProcessPlan& plan, const ComponentSpec& spec,
                              std::vector<int>& values_read) {
  const int index = static_cast<int>(build.plan.processes.size());
  for (std::size_t p = 0; p < plan.ports.size(); ++p) {
    const int value = plan.ports[p];
    if (value < 0) continue;
    if (spec.ports[p].access == PortAccess::reads) {
      values_read.push_back(value);
      continue;
    }
    auto& block = build.plan.blocks[as_size(value)];
    if (block.process >= 0)
      error("B019", join_pointer(join_pointer(plan.pointer, "blocks"), spec.ports[p].name),
            "block '" + block.name + "' is advanced by '" + build.plan.processes[as_size(block.process)].name +
                "' already; exactly one process model moves a block");
    else
      block.process = index;
  }
}

bool Composer::add_process(FilterBuild& build, const std::string& name, const std::string& pointer, bool is_whole,
                           std::vector<int>& values_read) {
  const std::size_t errors = error_count();
  ProcessPlan plan;
  plan.name = name;
  plan.pointer = pointer;
  const ComponentType* type = type_of(Role::process_model, pointer);
  if (!type) return false;
  const ComponentSpec& spec = type->spec;
  plan.type = type->full_name();
  std::vector<PortBinding> bindings;
  const bool is_bound = bind_ports(build, *type, pointer, plan.ports, bindings);
  std::vector<std::string> reserved{"type", "blocks", "input", "fields", "samples_per_step"};
  if (!spec.inputs.empty()) reserved.push_back("inputs");
  const auto parameters =
      check_parameters(spec.parameters, spec.type, document(), pointer, reserved, port_units(bindings), diagnostics_);
  std::vector<bool> fields_bound(spec.fields.size(), false), inputs_bound;
  int samples_per_step = 1;
  is_whole = read_process_input(build, plan, spec, fields_bound, samples_per_step) && is_whole;
  is_whole = read_auxiliary(build, plan.auxiliary, pointer, spec, fields_bound, inputs_bound) && is_whole;
  if (!is_bound || error_count() != errors || !is_whole) {
    // Its blocks are advanced by it in intention, whatever else is wrong with it.
    for (std::size_t p = 0; p < plan.ports.size(); ++p)
      if (spec.ports[p].access == PortAccess::advances && plan.ports[p] >= 0 &&
          plan.ports[p] < static_cast<int>(build.plan.blocks.size()))
        build.plan.blocks[as_size(plan.ports[p])].process = 0;
    return false;
  }
  guarded(pointer, [&](Findings& findings) {
    plan.model =
        type->create_process_model(Binding(name, Parameters(parameters), bindings, fields_bound, samples_per_step)
                                       .of(spec, inputs_bound)
                                       .telling(findings));
  });
  if (!plan.model || !check_couplings(plan, spec, bindings)) return false;
  advance_blocks(build, plan, spec, values_read);
  build.plan.max_fields = std::max(build.plan.max_fields, static_cast<int>(plan.fields.epoch.size()));
  build.plan.processes.push_back(std::move(plan));
  return true;
}

void Composer::add_processes(FilterBuild& build) {
  const std::string section = join_pointer(build.pointer, "process");
  const auto* processes = object_at(document(), section, "'process'", diagnostics_);
  std::vector<int> values_read;
  bool is_whole = processes != nullptr;
  if (processes)
    for (const auto& item : processes->items())
      is_whole = add_process(build, item.key(), join_pointer(section, item.key()), is_whole, values_read) && is_whole;
  if (!is_whole) build.is_complete = false;
  if (is_whole || !processes)
    for (const auto& block : build.plan.blocks)
      if (block.process < 0)
        key_error("B018", block.pointer,
                  "block '" + block.name + "' is advanced by no process model" +
                      constant_hint(plan_->catalog, block.name));
  build.plan.process_derived = derived_closure(build, values_read);
}

}  // namespace binnacle::compose
