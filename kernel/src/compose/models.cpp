// SPDX-License-Identifier: Apache-2.0
// Ports, derived blocks and process models of a filter.
#include <algorithm>

#include "compose/composer.hpp"

namespace binnacle::compose {

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

bool Composer::bind_ports(FilterBuild& build, Component& component) {
  const auto& spec = component.spec();
  const std::size_t errors = error_count();
  bool is_whole = true;
  const std::string blocks_pointer = join_pointer(component.pointer, "blocks");
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
      key_error("B017", component.pointer,
                "port '" + port.name + "' of '" + spec.type + "' is not bound (kind '" + port.kind +
                    "'): \"blocks\": {\"" + port.name + "\": \"" +
                    (fitting.empty() ? std::string("…") : fitting.front()) + "\"}");
    }
    component.values.push_back(binding.bound ? value : -1);
    component.ports.push_back(std::move(binding));
  }
  if (!is_whole) build.is_complete = false;
  return is_whole && error_count() == errors;
}

void Composer::find_input(FilterBuild& build) {
  const std::string pointer = join_pointer(build.pointer, "process");
  const auto* processes = object_at(document(), pointer, "'process'", diagnostics_);
  if (!processes) return;
  std::string first, first_pointer;
  for (const auto& item : processes->items()) {
    const std::string input_pointer = join_pointer(join_pointer(pointer, item.key()), "input");
    const auto channel = read_string(document(), input_pointer, diagnostics_);
    if (!channel || *channel == first) continue;
    if (!first.empty()) {
      error("B020", input_pointer,
            "filter '" + build.plan.name + "' is driven by channel '" + first + "' already (" + first_pointer +
                "); a filter has at most one driving input");
      continue;
    }
    first = *channel;
    first_pointer = input_pointer;
    bool is_told = false;
    build.plan.input_channel = channel_named(first, input_pointer, is_told);
    if (build.plan.input_channel < 0) build.is_complete = false;
  }
  if (build.plan.input_channel < 0) return;
  const auto& channel = plan_->channels[as_size(build.plan.input_channel)];
  build.plan.input_fields = channel.epoch_fields;
  build.plan.input_used.assign(as_size(channel.epoch_fields), 0);
  for (const auto& field : channel.declaration.fields)
    if (!field.is_per_row) build.plan.input_kinds.push_back(field.kind);
}

bool Composer::find_driving_rates(FilterBuild& build, Component& component) {
  const ComponentSpec& spec = component.spec();
  const auto& rates = spec.driving_rates;
  if (rates.empty()) return true;
  if (build.plan.input_channel < 0) {
    const bool all_optional =
        std::all_of(rates.begin(), rates.end(), [](const FieldSpec& field) { return field.is_optional; });
    if (!all_optional && build.is_complete)
      error("B021", component.pointer,
            "'" + spec.type + "' needs the rates of the filter's driving input, which has none");
    return all_optional;
  }
  const auto& channel = plan_->channels[as_size(build.plan.input_channel)];
  const std::size_t errors = error_count();
  for (const auto& wanted : rates) {
    int index = -1;
    for (std::size_t i = 0; i < channel.declaration.fields.size(); ++i)
      if (channel.declaration.fields[i].name == wanted.name) index = channel.position[i];
    if (index < 0 && !wanted.is_optional)
      error("B021", component.pointer,
            "the driving input '" + channel.name + "' has no field '" + wanted.name + "' that '" + spec.type +
                "' needs");
    if (index < 0) continue;
    component.driving_rates.push_back(index);
    build.plan.input_used[as_size(index)] = 1;
  }
  if (component.driving_rates.size() != rates.size()) component.driving_rates.clear();
  return error_count() == errors;
}

bool Composer::read_auxiliary(FilterBuild& build, AuxiliaryPlan& auxiliary, Component& component) {
  if (component.spec().inputs.empty()) return true;
  std::vector<NodeInput> inputs;
  const bool is_whole = read_inputs(component, inputs);
  auto& kept = build.plan.auxiliary;
  for (auto& input : inputs) {
    int index = -1;
    if (input.channel >= 0) {
      const auto same = [&](const LatestPlan& latest) { return latest.channel == input.channel; };
      index = static_cast<int>(std::find_if(kept.begin(), kept.end(), same) - kept.begin());
      if (as_size(index) == kept.size()) kept.push_back(LatestPlan{input.channel, 0, {}, {}});
    }
    auxiliary.channels.push_back(index);
    auxiliary.fields.push_back(std::move(input.fields));
  }
  return is_whole;
}

bool Composer::reads_bound_ports(const std::vector<int>& read_ports, const Component& component) {
  const bool all_are_bound = std::all_of(read_ports.begin(), read_ports.end(), [&](int port) {
    return port >= 0 && as_size(port) < component.values.size() && component.values[as_size(port)] >= 0;
  });
  if (!all_are_bound)
    error("B030", component.pointer,
          "'" + component.spec().type + "' declares a Jacobian for a port that is not bound");
  return all_are_bound;
}

bool Composer::add_derived_block(FilterBuild& build, const std::string& name, const std::string& pointer) {
  auto plan = planned<DerivedPlan>(name, pointer);
  const Component component = read_component(Role::derived_block, name, pointer, {"type", "blocks"}, &build);
  if (component.is_whole) plan.derived = make<DerivedBlock>(component);
  if (!plan.derived || !reads_bound_ports(plan.derived->declaration().read_ports, component)) return false;
  plan.type = component.type->full_name();
  plan.ports = component.values;
  plan.driving_rates = component.driving_rates;
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
  for (const auto& item : derived->items())
    if (build.value(item.key()) >= 0 || build.failed_values.contains(item.key()))
      key_error("B002", join_pointer(section, item.key()), "a block is called '" + item.key() + "' already");
  const auto is_waiting = [&](const std::string& name, const std::vector<std::string>& open) {
    const auto* blocks = at(join_pointer(join_pointer(section, name), "blocks"));
    if (!blocks || !blocks->is_object()) return false;
    return std::any_of(blocks->begin(), blocks->end(), [&](const auto& value) {
      return value.is_string() && build.value(value.template get<std::string>()) < 0 &&
             std::find(open.begin(), open.end(), value.template get<std::string>()) != open.end();
    });
  };
  const auto fail = [&](const std::string& name) {
    build.failed_values.insert(name);
    build.is_complete = false;
  };
  const auto cycle = in_order(section, "these derived blocks need each other: ", is_waiting,
                              [&](const std::string& name, const std::string& pointer) {
                                if (!add_derived_block(build, name, pointer)) fail(name);
                              });
  for (const auto& name : cycle) fail(name);
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

bool Composer::read_process_input(FilterBuild& build, ProcessPlan& plan, Component& component) {
  const ComponentSpec& spec = component.spec();
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
                      mappable_fields(spec))) {
    component.bind_fields(plan.fields);
    for (const auto& item : plan.fields.epoch)
      if (item.index >= 0) build.plan.input_used[as_size(item.index)] = 1;
  }
  const auto range = parameter::integer("samples_per_step").at_least(1).at_most(16);
  if (const auto samples =
          read_integer(document(), join_pointer(plan.pointer, "samples_per_step"), range, diagnostics_))
    component.samples_per_step = static_cast<int>(*samples);
  build.plan.samples_per_step = std::max(build.plan.samples_per_step, component.samples_per_step);
  return is_whole;
}

bool Composer::check_couplings(const ProcessPlan& plan, const Component& component) {
  const auto is_bound = [&](int port) {
    return port >= 0 && as_size(port) < plan.ports.size() && plan.ports[as_size(port)] >= 0;
  };
  const auto is_advanced = [&](int port) {
    return component.spec().ports[as_size(port)].access == PortAccess::advances;
  };
  const auto is_sound = [&](const Coupling& coupling, bool is_noise) {
    return is_bound(coupling.to) && is_bound(coupling.from) && is_advanced(coupling.to) &&
           (!is_noise || is_advanced(coupling.from)) &&
           (coupling.structure == Structure::dense ||
            component.ports[as_size(coupling.to)].dof == component.ports[as_size(coupling.from)].dof);
  };
  const auto& declared = plan.model->declaration();
  const bool all_are_sound = std::all_of(declared.transition.begin(), declared.transition.end(),
                                         [&](const Coupling& coupling) { return is_sound(coupling, false); }) &&
                             std::all_of(declared.noise.begin(), declared.noise.end(),
                                         [&](const Coupling& coupling) { return is_sound(coupling, true); });
  if (!all_are_sound)
    error("B030", plan.pointer,
          "'" + component.spec().type +
              "' declares a coupling of ports that are open, not advanced, or of unequal dof");
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
  auto plan = planned<ProcessPlan>(name, pointer);
  const std::size_t errors = error_count();
  Component component = read_component(Role::process_model, name, pointer,
                                       {"type", "blocks", "input", "fields", "samples_per_step"}, &build);
  if (!component.type) return false;
  const ComponentSpec& spec = component.spec();
  plan.type = component.type->full_name();
  plan.ports = component.values;
  is_whole = read_process_input(build, plan, component) && is_whole;
  is_whole = read_auxiliary(build, plan.auxiliary, component) && is_whole;
  if (!component.is_whole || error_count() != errors || !is_whole) {
    // Its blocks are advanced by it in intention, whatever else is wrong with it.
    for (std::size_t p = 0; p < plan.ports.size(); ++p)
      if (spec.ports[p].access == PortAccess::advances && plan.ports[p] >= 0 &&
          plan.ports[p] < static_cast<int>(build.plan.blocks.size()))
        build.plan.blocks[as_size(plan.ports[p])].process = 0;
    return false;
  }
  plan.model = make<ProcessModel>(component);
  if (!plan.model || !check_couplings(plan, component)) return false;
  advance_blocks(build, plan, spec, values_read);
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
