// SPDX-License-Identifier: Apache-2.0
// Ports, derived blocks and process models of a filter.
#include <algorithm>

#include "compose/composer.hpp"
#include "config/node.hpp"

namespace binnacle::internal::compose {

namespace {

/// "; a constant is {…}": by the type that moves blocks of any kind and asks for nothing, if there is one.
std::string constant_hint(Catalog& catalog, const std::string& block, Diagnostics& diagnostics) {
  catalog.load_waiting(diagnostics);
  for (const ComponentType* type : catalog.types()) {
    const ComponentSpec& spec = type->spec;
    if (type->role != Role::process_model || spec.ports.size() != 1 || spec.ports.front().kind != "*") continue;
    if (!spec.parameters.empty() || !spec.fields.empty()) continue;
    return "; a constant is {\"type\": \"" + spec.type + "\", \"blocks\": {\"" + spec.ports.front().name + "\": \"" +
           block + "\"}}";
  }
  return {};
}

/// Whether a model's couplings are of ports that are bound and advanced, and of equal dof where they are diagonal.
bool are_sound(const ProcessDeclaration& declared, const Component& component) {
  const auto is_bound = [&](int port) {
    return port >= 0 && port < count_of(component.ports) && component.ports[as_size(port)].bound;
  };
  const auto is_advanced = [&](int port) {
    return component.spec().ports[as_size(port)].access == PortAccess::advances;
  };
  const auto dof = [&](int port) { return component.ports[as_size(port)].dof; };
  const auto is_sound = [&](const Coupling& coupling) {
    return is_bound(coupling.to) && is_bound(coupling.from) && is_advanced(coupling.to) &&
           (coupling.structure == Structure::dense || dof(coupling.to) == dof(coupling.from));
  };
  return std::ranges::all_of(declared.transition, is_sound) && std::ranges::all_of(declared.noise, is_sound) &&
         std::ranges::all_of(declared.noise, is_advanced, &Coupling::from);
}

}  // namespace

int latest_of(std::vector<LatestPlan>& kept, int channel) {
  const int index = index_of(kept, channel, &LatestPlan::channel);
  if (index >= 0) return index;
  kept.emplace_back().channel = channel;
  return count_of(kept) - 1;
}

void FilterComposer::finish() {
  const std::size_t failures = composer.failures();
  constexpr int most_states = 2000;
  if (plan.n > most_states) {
    at["blocks"].key_error(config::too_large, "filter '" + plan.name + "' has " + std::to_string(plan.n) +
                                                  " error states; it may have " + std::to_string(most_states));
    return fail();
  }
  read_initial_values();
  find_input();
  add_derived();
  add_processes();
  add_measurements();
  read_trust();
  if (composer.failures() != failures) is_complete = false;
  if (!is_complete) return;
  plan_transition(*this);
  warn_of_dead_reckoning();
  warn_of_gates();
}

/// One whose refusals are expected is excepted from trust.
void FilterComposer::warn_of_gates() const {
  for (const auto& measurement : plan.measurements)
    if (measurement.gate > 0 && measurement.recover_after == 0 && measurement.is_watched)
      composer.place(measurement.pointer)["recover"].warning(
          "B113", "the gate of '" + measurement.name +
                      "' has no recovery: if the estimate is wrong, correct samples are refused to the end; if "
                      "refusals are expected, add it to \"except\" of the filter's \"trust\"");
}

/// A block of lengths that integrates one of velocities, and that no measurement sees: nothing bounds its error.
void FilterComposer::warn_of_dead_reckoning() const {
  const auto has_unit = [](const BlockPlan& block, const char* unit) {
    const auto its = parse_unit(block.declaration().error.front().unit);
    return its && its->dimension == parse_unit(unit)->dimension;
  };
  for (const auto& [to, from, structure] : info.transition) {
    const auto& block = plan.blocks[as_size(to)];
    const auto& rate = plan.blocks[as_size(from)];
    const auto sees_it = [&](const MeasurementPlan& seen) { return index_of(seen.columns, block.first) >= 0; };
    if (!has_unit(block, "m") || !has_unit(rate, "m/s") || std::ranges::any_of(plan.measurements, sees_it)) continue;
    composer.diagnostics().warning("B112", composer.place(block.pointer).key_origin(), block.pointer,
                                   "filter '" + plan.name + "' has no aiding of position: no measurement observes '" +
                                       block.name + "', the integral of '" + rate.name +
                                       "', so its error grows without bound");
  }
}

void FilterComposer::fail() {
  composer.fail();
  is_complete = false;
}

int FilterComposer::value_for(const PortSpec& port, const std::string& type, const Reader& port_at) {
  const auto name = port_at.text();
  if (!name || failed_values.contains(*name)) {
    fail();
    return -1;
  }
  const std::string what = "port '" + port.name + "' of '" + type + "' ";
  const int value = index_of(values, *name, &PortBinding::name);
  if (value < 0) {
    const auto names = names_of(values);
    port_at.error("B015",
                  "there is no block '" + *name + "'" + suggestion(*name, names) + " (blocks: " + listed(names) + ")");
  } else if (const auto& kind = values[as_size(value)].kind; !kind_matches(port.kind, kind)) {
    port_at.error("B016",
                  what + "takes a block of kind '" + port.kind + "'; '" + *name + "' is of kind '" + kind + "'");
  } else if (!plan.is_block(value) && port.access == PortAccess::advances) {
    port_at.error("B016", what + "advances its block; '" + *name + "' is derived and follows from others");
  } else {
    return value;
  }
  return -1;
}

void FilterComposer::bind_ports(Component& component) {
  const ComponentSpec& spec = component.spec();
  const Reader blocks = component.at["blocks"];
  const auto names = names_of(spec.ports);
  for (const Reader& block : blocks.members("'blocks'")) {
    if (index_of(names, block.key()) >= 0) continue;
    const int renamed = index_of(spec.ports, block.key(), &PortSpec::former_name);
    block.key_error("B012", "'" + spec.type + "' has no port '" + block.key() + "'" +
                                (renamed >= 0 ? "; it is now called '" + names[as_size(renamed)] + "'"
                                              : suggestion(block.key(), names)) +
                                " (ports: " + listed(names) + ")");
  }
  for (const auto& port : spec.ports) {
    const Reader port_at = blocks[port.name];
    const int value = port_at ? value_for(port, spec.type, port_at) : -1;
    if (!port_at && !port.is_optional) {
      const auto fitting =
          std::ranges::find_if(values, [&](const PortBinding& found) { return kind_matches(port.kind, found.kind); });
      component.at.key_error("B017", "port '" + port.name + "' of '" + spec.type + "' is not bound (kind '" +
                                         port.kind + "'): \"blocks\": {\"" + port.name + "\": \"" +
                                         (fitting == values.end() ? "…" : fitting->name) + "\"}");
    }
    component.values.push_back(value);
    component.ports.push_back(value < 0 ? PortBinding() : values[as_size(value)]);
    component.ports.back().name = port.name;
  }
}

void FilterComposer::find_input() {
  std::string first, first_pointer;
  for (const Reader& process : at["process"].members("'process'")) {
    const Reader input = process["input"];
    const auto channel = input.text();
    if (!channel || *channel == first) continue;
    if (!first.empty()) {
      input.error("B020", "filter '" + plan.name + "' is driven by channel '" + first + "' already (" + first_pointer +
                              "); a filter has at most one driving input");
      continue;
    }
    first = *channel;
    first_pointer = input.pointer();
    plan.input_channel = composer.channel_named(first, input);
    if (plan.input_channel < 0) is_complete = false;
  }
  if (plan.input_channel < 0) return;
  const ChannelPlan& channel = composer.channel(plan.input_channel);
  plan.input_fields = channel.epoch_fields;
  plan.input_used.assign(as_size(channel.epoch_fields), 0);
  for (const auto& field : channel.declaration.fields)
    if (!field.is_per_row) plan.input_kinds.push_back(field.kind);
}

void FilterComposer::find_driving_rates(Component& component) {
  const ComponentSpec& spec = component.spec();
  const auto& rates = spec.driving_rates;
  if (rates.empty()) return;
  if (plan.input_channel < 0) {
    if (std::ranges::all_of(rates, &FieldSpec::is_optional)) return;
    if (is_complete)
      component.at.error("B021", "'" + spec.type + "' needs the rates of the filter's driving input, which has none");
    return composer.fail();
  }
  const ChannelPlan& channel = composer.channel(plan.input_channel);
  for (const auto& wanted : rates) {
    const int found = index_of(channel.declaration.fields, wanted.name, &FieldSpec::name);
    if (found >= 0) {
      component.driving_rates.push_back(channel.position[as_size(found)]);
      plan.input_used[as_size(component.driving_rates.back())] = 1;
    } else if (!wanted.is_optional) {
      component.at.error("B021", "the driving input '" + channel.name + "' has no field '" + wanted.name + "' that '" +
                                     spec.type + "' needs");
    }
  }
  if (component.driving_rates.size() != rates.size()) component.driving_rates.clear();
}

void FilterComposer::read_auxiliary(AuxiliaryPlan& auxiliary, Component& component) {
  if (component.spec().inputs.empty()) return;
  for (auto& input : composer.read_inputs(component)) {
    auxiliary.channels.push_back(input.channel < 0 ? -1 : latest_of(plan.auxiliary, input.channel));
    auxiliary.fields.push_back(std::move(input.fields));
  }
}

bool FilterComposer::are_bound(const std::vector<int>& read_ports, const Component& component) {
  const bool all_are_bound = std::ranges::all_of(read_ports, [&](int port) {
    return port >= 0 && port < count_of(component.values) && component.values[as_size(port)] >= 0;
  });
  if (!all_are_bound)
    component.at.error("B030", "'" + component.spec().type + "' declares a Jacobian for a port that is not bound");
  return all_are_bound;
}

bool FilterComposer::add_derived_block(const Reader& derived_at) {
  auto derived = planned<DerivedPlan>(derived_at);
  const Component component = composer.read_component(Role::derived_block, derived_at, {"type", "blocks"}, this);
  derived.derived = composer.make<DerivedBlock>(component);
  if (!derived.derived || !are_bound(derived.derived->declaration().read_ports, component)) return false;
  derived.type = component.type->full_name();
  derived.ports = component.values;
  derived.driving_rates = component.driving_rates;
  const auto& declaration = derived.derived->declaration();
  const int dof = derived.dof();
  derived.value = reserve(as_size(declaration.stored_size));
  std::set<int> blocks;
  for (const int port : declaration.read_ports) {
    const int value = derived.ports[as_size(port)];
    derived.reads.push_back({value, reserve(as_size(dof * values[as_size(value)].dof)), port});
    if (plan.is_block(value))
      blocks.insert(value);
    else
      for (const auto& dependence : plan.derived_at(value).dependences) blocks.insert(dependence.block);
  }
  for (const int block : blocks)
    derived.dependences.push_back({block, reserve(as_size(dof * values[as_size(block)].dof))});
  const auto kind = canonical_kind(declaration.kind);
  if (!kind) derived_at.error("B030", kind.error());
  values.push_back(
      {derived.name, true, kind ? *kind : declaration.kind, dof, declaration.stored_size, declaration.error});
  plan.derived.push_back(std::move(derived));
  return true;
}

void FilterComposer::add_derived() {
  const Reader derived = at["derived"];
  if (!derived.is_object("'derived'")) return;
  const auto is_known = [&](const std::string& name) { return index_of(values, name, &PortBinding::name) >= 0; };
  for (const Reader& item : derived.children())
    if (is_known(item.key()) || failed_values.contains(item.key()))
      item.key_error("B002", "a block is called '" + item.key() + "' already");
  const auto is_waiting = [&](const Reader& item, const std::vector<std::string>& open) {
    return std::ranges::any_of(item["blocks"].children(), [&](const Reader& port) {
      return config::JsonOf::at(port).is_string() && !is_known(*port.text()) && index_of(open, *port.text()) >= 0;
    });
  };
  const auto fail_derived = [&](const std::string& name) {
    failed_values.insert(name);
    fail();
  };
  const auto cycle = composer.in_order(derived, "these derived blocks depend on each other in a cycle: ", is_waiting,
                                       [&](const Reader& item) {
                                         if (!add_derived_block(item)) fail_derived(item.key());
                                       });
  for (const auto& name : cycle) fail_derived(name);
}

std::vector<int> FilterComposer::derived_closure(std::vector<int> open) const {
  std::set<int> needed;
  while (!open.empty()) {
    const int value = open.back();
    open.pop_back();
    if (plan.is_block(value) || !needed.insert(value).second) continue;
    const auto& ports = plan.derived_at(value).ports;
    open.insert(open.end(), ports.begin(), ports.end());
  }
  return {needed.begin(), needed.end()};
}

void FilterComposer::read_process_input(ProcessPlan& process, Component& component) {
  const ComponentSpec& spec = component.spec();
  const Reader input = component.at["input"];
  process.uses_input = !spec.fields.empty();
  if (!process.uses_input) {
    if (input) input.key_error("B012", "'" + spec.type + "' takes no input");
    return;
  }
  if (!input) {
    component.at.key_error("B010", "'input' of '" + spec.type + "' is missing (name of a channel)");
  } else if (plan.input_channel < 0) {
    composer.fail();
  } else {
    process.fields = composer.bind_fields(component, spec.fields, plan.input_channel, input);
    for (const auto& item : process.fields.epoch)
      if (item.index >= 0) plan.input_used[as_size(item.index)] = 1;
  }
  const auto range = parameter::integer("samples_per_step").at_least(1).at_most(16);
  component.samples_per_step = static_cast<int>(component.at["samples_per_step"].integer(range).value_or(1));
  plan.samples_per_step = std::max(plan.samples_per_step, component.samples_per_step);
}

bool FilterComposer::add_process(const Reader& process_at, bool is_whole) {
  auto process = planned<ProcessPlan>(process_at);
  Component component = composer.read_component(Role::process_model, process_at,
                                                {"type", "blocks", "input", "fields", "samples_per_step"}, this);
  if (!component.type) return false;
  process.type = component.type->full_name();
  process.ports = component.values;
  read_process_input(process, component);
  read_auxiliary(process.auxiliary, component);
  if (!is_whole || composer.failures() != component.failures) {
    // Its blocks are advanced by it in intention, whatever else is wrong with it.
    for (std::size_t p = 0; p < process.ports.size(); ++p)
      if (component.spec().ports[p].access == PortAccess::advances && process.ports[p] >= 0)
        plan.blocks[as_size(process.ports[p])].process = 0;
    return false;
  }
  process.model = composer.make<ProcessModel>(component);
  if (!process.model) return false;
  if (!are_sound(process.model->declaration(), component)) {
    process_at.error("B030", "'" + component.spec().type +
                                 "' declares a coupling of ports that are open, not advanced, or of unequal dof");
    return false;
  }
  for (std::size_t p = 0; p < process.ports.size(); ++p) {
    const PortSpec& port = component.spec().ports[p];
    if (process.ports[p] < 0 || port.access == PortAccess::reads) continue;
    auto& block = plan.blocks[as_size(process.ports[p])];
    if (block.process == count_of(plan.processes))
      component.at["blocks"][port.name].error("B019", "block '" + block.name + "' is on two ports of '" + process.name +
                                                          "' that advance it; each needs its own block");
    else if (block.process >= 0)
      component.at["blocks"][port.name].error("B019", "block '" + block.name + "' is advanced by '" +
                                                          plan.processes[as_size(block.process)].name +
                                                          "' already; exactly one process model advances a block");
    else
      block.process = count_of(plan.processes);
  }
  plan.processes.push_back(std::move(process));
  return true;
}

void FilterComposer::add_processes() {
  const Reader processes = at["process"];
  const bool is_there = processes.is_object("'process'");
  bool is_whole = is_there;
  for (const Reader& process : processes.members("'process'")) is_whole = add_process(process, is_whole) && is_whole;
  if (!is_whole) is_complete = false;
  if (is_whole || !is_there)
    for (const auto& block : plan.blocks)
      if (block.process < 0)
        composer.place(block.pointer)
            .key_error("B018", "block '" + block.name + "' is advanced by no process model" +
                                   constant_hint(composer.plan().catalog, block.name, composer.diagnostics()));
  std::vector<int> ports;
  for (const auto& process : plan.processes) ports.insert(ports.end(), process.ports.begin(), process.ports.end());
  plan.process_derived = derived_closure(ports);
}

}  // namespace binnacle::internal::compose
