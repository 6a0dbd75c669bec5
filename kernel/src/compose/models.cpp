// SPDX-License-Identifier: Apache-2.0
// Derived blocks, process and measurement models of a filter: ports, fields, noise, gates.
#include <algorithm>
#include <cmath>

#include <boost/math/distributions/chi_squared.hpp>

#include "compose/composer.hpp"

#include "base/index.hpp"

namespace binnacle::compose {

using base::as_size;

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

bool Composer::bind_ports(FilterBuild& build, const ComponentType& type, const std::string& pointer,
                          std::vector<int>& ports, std::vector<PortBinding>& bindings) {
  const auto& spec = type.spec;
  const std::size_t errors = error_count();
  bool is_whole = true;
  const std::string blocks_pointer = join_pointer(pointer, "blocks");
  const auto* blocks = object_at(document(), blocks_pointer, "'blocks'", diagnostics_);
  std::vector<std::string> port_names;
  for (const auto& port : spec.ports) port_names.push_back(port.name);
  if (blocks)
    for (const auto& [key, value] : blocks->items())
      if (std::find(port_names.begin(), port_names.end(), key) == port_names.end()) {
        const auto renamed = std::find_if(spec.ports.begin(), spec.ports.end(),
                                          [&, &key = key](const PortSpec& port) { return port.former_name == key; });
        key_error("B012", join_pointer(blocks_pointer, key),
                  "'" + spec.type + "' has no port '" + key + "'" +
                      (renamed != spec.ports.end() ? "; it is now called '" + renamed->name + "'"
                                                   : suggestion(key, port_names)) +
                      " (ports: " + listed(port_names) + ")");
      }
  for (const auto& port : spec.ports) {
    PortBinding binding;
    binding.name = port.name;
    int value = -1;
    if (blocks && blocks->contains(port.name)) {
      const std::string port_pointer = join_pointer(blocks_pointer, port.name);
      const auto name = read_string(document(), port_pointer, diagnostics_);
      if (!name) {
        is_whole = false;
      } else if (build.failed_values.contains(*name)) {
        is_whole = false;
      } else if ((value = build.value(*name)) < 0) {
        std::vector<std::string> names;
        for (const auto& info : build.values) names.push_back(info.name);
        error("B015", port_pointer,
              "there is no block '" + *name + "'" + suggestion(*name, names) + " (blocks: " + listed(names) + ")");
      } else {
        const auto& info = build.values[as_size(value)];
        if (!kind_matches(port.kind, info.kind)) {
          error("B016", port_pointer,
                "port '" + port.name + "' of '" + spec.type + "' takes a block of kind '" + port.kind + "'; '" + *name +
                    "' is of kind '" + info.kind + "'");
        } else if (info.is_derived && port.access == PortAccess::advances) {
          error("B016", port_pointer,
                "port '" + port.name + "' of '" + spec.type + "' advances its block; '" + *name +
                    "' is derived and follows from others");
        } else {
          binding.bound = true;
          binding.kind = info.kind;
          binding.dof = info.dof;
          binding.stored_size = info.stored_size;
          binding.components = info.components;
        }
      }
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

void Composer::add_derived(FilterBuild& build) {
  const std::string section = join_pointer(build.pointer, "derived");
  const auto* derived = object_at(document(), section, "'derived'", diagnostics_);
  if (!derived) return;
  std::vector<std::string> waiting;
  for (const auto& [name, value] : derived->items()) {
    waiting.push_back(name);
    if (build.value(name) >= 0 || build.failed_values.contains(name))
      key_error("B002", join_pointer(section, name), "a block is called '" + name + "' already");
  }
  const auto is_pending = [&](const std::string& name) {
    const auto* blocks = at(join_pointer(join_pointer(section, name), "blocks"));
    if (!blocks || !blocks->is_object()) return false;
    for (const auto& [port, value] : blocks->items())
      if (value.is_string() && build.value(value.get<std::string>()) < 0 &&
          std::find(waiting.begin(), waiting.end(), value.get<std::string>()) != waiting.end())
        return true;
    return false;
  };
  while (!waiting.empty()) {
    std::vector<std::string> later;
    for (const auto& name : waiting) {
      if (is_pending(name)) {
        later.push_back(name);
        continue;
      }
      const std::string pointer = join_pointer(section, name);
      const std::size_t errors = error_count();
      DerivedPlan plan;
      plan.name = name;
      plan.pointer = pointer;
      const ComponentType* type = type_of(Role::derived_block, pointer);
      std::vector<PortBinding> bindings;
      if (type) {
        plan.type = type->full_name();
        const bool is_bound = bind_ports(build, *type, pointer, plan.ports, bindings);
        const auto parameters = check_parameters(type->spec.parameters, type->spec.type, document(), pointer,
                                                 {"type", "blocks"}, port_units(bindings), diagnostics_);
        const bool has_drive = find_driving_rates(build, *type, pointer, plan.driving_rates);
        if (is_bound && has_drive && error_count() == errors)
          guarded(pointer, [&](Findings& findings) {
            plan.derived = type->create_derived_block(Binding(name, Parameters(parameters), bindings, {})
                                                          .of(type->spec, {}, !plan.driving_rates.empty())
                                                          .telling(findings));
          });
      }
      if (!plan.derived) {
        build.failed_values.insert(name);
        build.is_complete = false;
        continue;
      }
      const auto& declaration = plan.derived->declaration();
      const int dof = plan.dof();
      plan.value = build.reserve(as_size(declaration.stored_size));
      std::set<int> blocks;
      const bool reads_are_bound =
          std::all_of(declaration.read_ports.begin(), declaration.read_ports.end(), [&](int port) {
            return port >= 0 && as_size(port) < plan.ports.size() && plan.ports[as_size(port)] >= 0;
          });
      if (!reads_are_bound) {
        error("B030", pointer, "'" + type->spec.type + "' declares a Jacobian for a port that is not bound");
        build.failed_values.insert(name);
        build.is_complete = false;
        continue;
      }
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

void Composer::add_processes(FilterBuild& build) {
  const std::string section = join_pointer(build.pointer, "process");
  const auto* processes = object_at(document(), section, "'process'", diagnostics_);
  std::vector<int> process_values;
  bool is_whole = processes != nullptr;
  if (processes)
    for (const auto& [name, value] : processes->items()) {
      const std::string pointer = join_pointer(section, name);
      const std::size_t errors = error_count();
      ProcessPlan plan;
      plan.name = name;
      plan.pointer = pointer;
      const ComponentType* type = type_of(Role::process_model, pointer);
      if (!type) {
        is_whole = false;
        continue;
      }
      plan.type = type->full_name();
      std::vector<PortBinding> bindings;
      const bool is_bound = bind_ports(build, *type, pointer, plan.ports, bindings);
      const auto parameters = check_parameters(type->spec.parameters, type->spec.type, document(), pointer,
                                               {"type", "blocks", "input", "fields", "samples_per_step"},
                                               port_units(bindings), diagnostics_);
      plan.uses_input = !type->spec.fields.empty();
      std::vector<bool> fields_bound(type->spec.fields.size(), false);
      int samples_per_step = 1;
      if (plan.uses_input) {
        const std::string input_pointer = join_pointer(pointer, "input");
        if (!at(input_pointer))
          key_error("B010", pointer, "'input' of '" + type->spec.type + "' is missing (name of a channel)");
        else if (build.plan.input_channel < 0)
          is_whole = false;
        else if (map_fields(type->spec.fields, build.plan.input_channel, pointer, input_pointer, type->spec.type,
                            plan.fields))
          for (const auto& item : plan.fields.epoch) {
            fields_bound[as_size(item.declared)] = item.index >= 0;
            if (item.index >= 0) build.plan.input_used[as_size(item.index)] = 1;
          }
        const std::string samples_pointer = join_pointer(pointer, "samples_per_step");
        if (at(samples_pointer)) {
          auto spec = parameter::integer("samples_per_step");
          spec.minimum = 1;
          spec.maximum = 16;
          if (const auto samples = read_integer(document(), samples_pointer, spec, diagnostics_))
            samples_per_step = static_cast<int>(*samples);
          build.plan.samples_per_step = std::max(build.plan.samples_per_step, samples_per_step);
        }
      } else if (at(join_pointer(pointer, "input"))) {
        key_error("B012", join_pointer(pointer, "input"), "'" + type->spec.type + "' takes no input");
      }
      if (!is_bound || error_count() != errors || !is_whole) {
        // Its blocks are advanced by it in intention, whatever else is wrong with it.
        for (std::size_t p = 0; p < plan.ports.size(); ++p)
          if (type->spec.ports[p].access == PortAccess::advances && plan.ports[p] >= 0 &&
              plan.ports[p] < static_cast<int>(build.plan.blocks.size()))
            build.plan.blocks[as_size(plan.ports[p])].process = 0;
        is_whole = false;
        continue;
      }
      guarded(pointer, [&, &name = name](Findings& findings) {
        plan.model =
            type->create_process_model(Binding(name, Parameters(parameters), bindings, fields_bound, samples_per_step)
                                           .of(type->spec)
                                           .telling(findings));
      });
      if (!plan.model) {
        is_whole = false;
        continue;
      }
      const auto is_sound = [&](const Coupling& coupling, bool is_noise) {
        const auto is_bound_port = [&](int port) {
          return port >= 0 && as_size(port) < plan.ports.size() && plan.ports[as_size(port)] >= 0;
        };
        const auto is_advanced = [&](int port) {
          return type->spec.ports[as_size(port)].access == PortAccess::advances;
        };
        return is_bound_port(coupling.to) && is_bound_port(coupling.from) && is_advanced(coupling.to) &&
               (!is_noise || is_advanced(coupling.from)) &&
               (coupling.structure == Structure::dense ||
                bindings[as_size(coupling.to)].dof == bindings[as_size(coupling.from)].dof);
      };
      const auto& declared = plan.model->declaration();
      const bool couplings_are_sound =
          std::all_of(declared.transition.begin(), declared.transition.end(),
                      [&](const Coupling& coupling) { return is_sound(coupling, false); }) &&
          std::all_of(declared.noise.begin(), declared.noise.end(),
                      [&](const Coupling& coupling) { return is_sound(coupling, true); });
      if (!couplings_are_sound) {
        error("B030", pointer,
              "'" + type->spec.type + "' declares a coupling of ports that are open, not advanced, or of unequal dof");
        is_whole = false;
        continue;
      }
      const int index = static_cast<int>(build.plan.processes.size());
      for (std::size_t p = 0; p < plan.ports.size(); ++p) {
        const int port_value = plan.ports[p];
        if (port_value < 0) continue;
        if (type->spec.ports[p].access == PortAccess::reads) {
          process_values.push_back(port_value);
          continue;
        }
        auto& block = build.plan.blocks[as_size(port_value)];
        if (block.process >= 0)
          error("B019", join_pointer(join_pointer(pointer, "blocks"), type->spec.ports[p].name),
                "block '" + block.name + "' is advanced by '" + build.plan.processes[as_size(block.process)].name +
                    "' already; exactly one process model moves a block");
        else
          block.process = index;
      }
      build.plan.max_fields = std::max(build.plan.max_fields, static_cast<int>(plan.fields.epoch.size()));
      build.plan.processes.push_back(std::move(plan));
    }
  if (!is_whole) build.is_complete = false;
  if (is_whole || !processes)
    for (const auto& block : build.plan.blocks)
      if (block.process < 0)
        key_error("B018", block.pointer,
                  "block '" + block.name +
                      "' is advanced by no process model; a constant is {\"type\": \"random_constant\", "
                      "\"blocks\": {\"x\": \"" +
                      block.name + "\"}}");
  build.plan.process_derived = derived_closure(build, process_values);
}

void Composer::add_measurements(FilterBuild& build) {
  const std::string section = join_pointer(build.pointer, "measurements");
  const auto* measurements = object_at(document(), section, "'measurements'", diagnostics_);
  if (!measurements) return;
  for (const auto& [name, value] : measurements->items())
    if (!add_measurement(build, name, join_pointer(section, name))) build.is_complete = false;
}

bool Composer::add_measurement(FilterBuild& build, const std::string& name, const std::string& pointer) {
  const std::size_t errors = error_count();
  if (!object_at(document(), pointer, "measurement '" + name + "'", diagnostics_)) return false;
  MeasurementPlan measurement;
  measurement.name = name;
  measurement.pointer = pointer;
  const std::vector<std::string> common{"channel", "noise", "gate", "recover", "withhold"};
  if (!require_key(document(), pointer, "channel", name, "name of a channel", diagnostics_)) return false;
  const std::string channel_pointer = join_pointer(pointer, "channel");
  const auto channel = read_string(document(), channel_pointer, diagnostics_);
  if (!channel) return false;
  bool is_told = false;
  measurement.channel = channel_named(*channel, channel_pointer, is_told);
  bool is_whole = measurement.channel >= 0;

  const std::string stack_pointer = join_pointer(pointer, "stack");
  if (at(stack_pointer)) {
    auto allowed = common;
    allowed.push_back("stack");
    check_keys(document(), pointer, allowed, "stack '" + name + "'", diagnostics_);
    const auto* stack = object_at(document(), stack_pointer, "'stack'", diagnostics_);
    if (!stack) return false;
    if (stack->empty()) error("B010", stack_pointer, "the stack '" + name + "' is empty");
    for (const auto& [part, value] : stack->items())
      is_whole = add_part(build, measurement, part, join_pointer(stack_pointer, part),
                          {"type", "blocks", "fields", "inputs"}) &&
                 is_whole;
  } else {
    auto reserved = common;
    for (const char* key : {"type", "blocks", "fields", "inputs"}) reserved.push_back(key);
    is_whole = add_part(build, measurement, name, pointer, reserved) && is_whole;
  }
  if (!is_whole || error_count() != errors) return false;

  collect_touched(build, measurement);
  add_gate(measurement, join_pointer(pointer, "gate"));
  measurement.gate_limit.assign(as_size(measurement.max_rows) + 1, 0.0);
  if (measurement.gate > 0)
    for (int m = 1; m <= measurement.max_rows; ++m)
      measurement.gate_limit[as_size(m)] = boost::math::quantile(boost::math::chi_squared(m), measurement.gate);
  add_noise(build, measurement, pointer);
  add_recovery(build, measurement, pointer);
  add_withholding(measurement, pointer);
  if (error_count() != errors) return false;
  build.plan.max_rows = std::max(build.plan.max_rows, measurement.max_rows);
  build.plan.max_columns = std::max(build.plan.max_columns, static_cast<int>(measurement.columns.columns.size()));
  build.plan.measurements.push_back(std::move(measurement));
  return true;
}

bool Composer::add_part(FilterBuild& build, MeasurementPlan& measurement, const std::string& name,
                        const std::string& pointer, const std::vector<std::string>& reserved) {
  const std::size_t errors = error_count();
  PartPlan part;
  part.name = name;
  part.pointer = pointer;
  const ComponentType* type = type_of(Role::measurement_model, pointer);
  if (!type) return false;
  part.type = type->full_name();
  std::vector<PortBinding> bindings;
  bool is_whole = bind_ports(build, *type, pointer, part.ports, bindings);
  const auto parameters = check_parameters(type->spec.parameters, type->spec.type, document(), pointer, reserved,
                                           port_units(bindings), diagnostics_);
  is_whole = find_driving_rates(build, *type, pointer, part.driving_rates) && is_whole;
  std::vector<bool> fields_bound(type->spec.fields.size(), false);
  if (measurement.channel >= 0) {
    const std::string channel_pointer = join_pointer(measurement.pointer, "channel");
    is_whole = map_fields(type->spec.fields, measurement.channel, pointer, channel_pointer, type->spec.type,
                          part.fields, mappable_fields(type->spec)) &&
               is_whole;
    for (const auto& item : part.fields.epoch) fields_bound[as_size(item.declared)] = item.index >= 0;
    for (const auto& item : part.fields.row) fields_bound[as_size(item.declared)] = item.index >= 0;
    const auto& channel = plan_->channels[as_size(measurement.channel)];
    build.plan.max_row_fields =
        std::max(build.plan.max_row_fields, static_cast<int>(part.fields.row.size()) * channel.declaration.max_rows);
  } else {
    is_whole = false;  // what is wrong with the channel is told; its missing fields are not the model's to complain of
  }
  build.plan.max_fields = std::max(build.plan.max_fields, static_cast<int>(part.fields.epoch.size()));

  std::vector<bool> inputs_bound;
  if (!type->spec.inputs.empty()) {
    std::vector<NodeInput> inputs;
    is_whole = read_inputs(type->spec, pointer, inputs) && is_whole;
    for (auto& input : inputs) {
      int index = -1;
      if (input.channel >= 0) {
        for (std::size_t i = 0; i < build.plan.auxiliary.size(); ++i)
          if (build.plan.auxiliary[i].channel == input.channel) index = static_cast<int>(i);
        if (index < 0) {
          index = static_cast<int>(build.plan.auxiliary.size());
          build.plan.auxiliary.push_back(LatestPlan{input.channel, 0, {}, {}, {}});
        }
      }
      part.auxiliary.push_back(index);
      inputs_bound.push_back(index >= 0);
      const auto first = fields_bound.size();
      fields_bound.resize(first + type->spec.inputs[inputs_bound.size() - 1].fields.size(), false);
      for (const auto* items : {&input.fields.epoch, &input.fields.row})
        for (const auto& item : *items) fields_bound[first + as_size(item.declared)] = item.index >= 0;
      part.auxiliary_fields.push_back(std::move(input.fields));
    }
  }
  if (!is_whole || measurement.channel < 0 || error_count() != errors) return false;
  if (!guarded(pointer, [&](Findings& findings) {
        part.model = type->create_measurement_model(
            Binding(name, Parameters(parameters), bindings, fields_bound, 1,
                    {plan_->channels[as_size(measurement.channel)].declaration.covariance})
                .of(type->spec, inputs_bound, !part.driving_rates.empty())
                .telling(findings));
      }))
    return false;
  const auto& declaration = part.model->declaration();
  if (declaration.max_rows < 1) {
    error("B030", pointer, "'" + type->spec.type + "' declares no rows");
    return false;
  }
  for (const int port : declaration.read_ports) {
    if (port < 0 || as_size(port) >= part.ports.size() || part.ports[as_size(port)] < 0) {
      error("B030", pointer, "'" + type->spec.type + "' declares a Jacobian for a port that is not bound");
      return false;
    }
    const int value = part.ports[as_size(port)];
    const int dof = build.values[as_size(value)].dof;
    part.reads.push_back({value, dof, build.reserve(as_size(declaration.max_rows * dof)), {}, port});
  }
  measurement.max_rows += declaration.max_rows;
  measurement.parts.push_back(std::move(part));
  return true;
}

void Composer::collect_touched(FilterBuild& build, MeasurementPlan& measurement) {
  const int blocks = static_cast<int>(build.plan.blocks.size());
  std::vector<int> values;
  std::set<int> touched;
  const auto dependences = [&](int value) {
    std::vector<std::pair<int, std::size_t>> found;  // block, chain
    if (value < blocks)
      found.emplace_back(value, 0);
    else
      for (const auto& dependence : build.plan.derived[as_size(value - blocks)].dependences)
        found.emplace_back(dependence.block, dependence.jacobian);
    return found;
  };
  for (const auto& part : measurement.parts) {
    for (const int port : part.ports)
      if (port >= 0) values.push_back(port);
    for (const auto& read : part.reads)
      for (const auto& [block, chain] : dependences(read.value))
        if (!build.plan.blocks[as_size(block)].active.empty()) touched.insert(block);
  }
  measurement.derived = derived_closure(build, values);
  std::map<int, int> first_column;
  for (const int block : touched) {
    first_column[block] = static_cast<int>(measurement.columns.columns.size());
    const auto& plan = build.plan.blocks[as_size(block)];
    for (std::size_t a = 0; a < plan.active.size(); ++a)
      measurement.columns.columns.push_back(plan.first + static_cast<int>(a));
  }
  for (auto& part : measurement.parts)
    for (auto& read : part.reads)
      for (const auto& [block, chain] : dependences(read.value))
        if (first_column.contains(block))
          read.targets.push_back({block, first_column[block], read.value < blocks, chain});
}

/// `"gate": 0.999` of whole samples, or {"probability": 0.999, "by": "row"} of rows or of keys.
void Composer::add_gate(MeasurementPlan& measurement, const std::string& pointer) {
  const auto* gate = at(pointer);
  if (!gate) return;
  std::string probability_pointer = pointer;
  if (gate->is_object()) {
    check_keys(document(), pointer, {"probability", "by"}, "'gate'", diagnostics_);
    if (!require_key(document(), pointer, "probability", "gate", "0 < p < 1", diagnostics_)) return;
    probability_pointer = join_pointer(pointer, "probability");
    const std::string by_pointer = join_pointer(pointer, "by");
    if (at(by_pointer)) {
      const std::vector<std::string> units{"sample", "row", "key"};
      if (const auto by = read_string(document(), by_pointer, diagnostics_)) {
        const auto found = std::find(units.begin(), units.end(), *by);
        if (found == units.end())
          error("B009", by_pointer, "a gate is by sample, row or key; found '" + *by + "'" + suggestion(*by, units));
        else
          measurement.gate_unit = static_cast<GateUnit>(found - units.begin());
      }
    }
  }
  auto spec = parameter::number("gate", "1").about("probability");
  spec.minimum = 0;
  spec.maximum = 1;
  spec.minimum_excluded = spec.maximum_excluded = true;
  if (const auto probability = read_quantity(document(), probability_pointer, spec, diagnostics_))
    measurement.gate = *probability;
}

void Composer::add_noise(FilterBuild& build, MeasurementPlan& measurement, const std::string& pointer) {
  const std::string noise_pointer = join_pointer(pointer, "noise");
  if (!at(noise_pointer)) return;
  const std::size_t errors = error_count();
  const ComponentType* type = type_of(Role::noise_estimator, noise_pointer);
  if (!type) {
    build.is_complete = false;
    return;
  }
  const auto parameters = check_parameters(type->spec.parameters, type->spec.type, document(), noise_pointer,
                                           {"type", "learn_from_gated"}, {}, diagnostics_);
  const std::string learn_pointer = join_pointer(noise_pointer, "learn_from_gated");
  if (at(learn_pointer))
    if (const auto learn = read_bool(document(), learn_pointer, diagnostics_)) measurement.learn_from_gated = *learn;
  if (error_count() != errors) return;
  NoiseBinding binding;
  binding.max_rows = measurement.max_rows;
  int first = 0;
  for (const auto& part : measurement.parts) {
    for (const auto& group : part.model->declaration().groups) {
      binding.group_first_row.push_back(first + group.first_row);
      const std::string& unit = group.unit.empty() && group.port >= 0
                                    ? build.values[as_size(part.ports[as_size(group.port)])].components.front().unit
                                    : group.unit;
      binding.groups.push_back({measurement.parts.size() > 1 ? part.name + "." + group.name : group.name, unit});
    }
    if (part.model->declaration().groups.empty()) {
      binding.group_first_row.push_back(first);
      binding.groups.push_back({part.name, ""});
    }
    first += part.model->declaration().max_rows;
  }
  measurement.noise_type = type->full_name();
  guarded(noise_pointer, [&](Findings& findings) {
    measurement.noise = type->create_noise_estimator(
        Binding(measurement.name, Parameters(parameters), {}, {}).of(type->spec).telling(findings), binding);
  });
}

void Composer::add_recovery(FilterBuild& build, MeasurementPlan& measurement, const std::string& pointer) {
  const std::string recover_pointer = join_pointer(pointer, "recover");
  const auto* recover = object_at(document(), recover_pointer, "'recover'", diagnostics_);
  if (!recover) return;
  check_keys(document(), recover_pointer, {"after", "inflate"}, "'recover'", diagnostics_);
  if (!require_key(document(), recover_pointer, "after", "recover", "samples gated in a row", diagnostics_) ||
      !require_key(document(), recover_pointer, "inflate", "recover", "{\"block.component\": sigma}", diagnostics_))
    return;
  if (measurement.gate <= 0)
    error("B010", recover_pointer, "'recover' needs a 'gate': without one no sample is ever gated");
  auto spec = parameter::integer("after");
  spec.minimum = 1;
  if (const auto after = read_integer(document(), join_pointer(recover_pointer, "after"), spec, diagnostics_))
    measurement.recover_after = static_cast<int>(*after);
  const std::string inflate_pointer = join_pointer(recover_pointer, "inflate");
  const auto* inflate = object_at(document(), inflate_pointer, "'inflate'", diagnostics_);
  if (!inflate) return;
  std::vector<std::string> names;
  for (const auto& block : build.plan.blocks)
    for (const int active : block.active)
      names.push_back(block.name + "." + block.declaration().error[as_size(active)].name);
  for (const auto& [key, value] : inflate->items()) {
    const std::string entry = join_pointer(inflate_pointer, key);
    bool is_found = false;
    for (const auto& block : build.plan.blocks)
      for (std::size_t a = 0; a < block.active.size(); ++a) {
        const auto& component = block.declaration().error[as_size(block.active[a])];
        // A block's name alone means all of its components.
        if (key != block.name && key != block.name + "." + component.name) continue;
        is_found = true;
        auto bound = parameter::number(key, component.unit);
        bound.minimum = 0;
        if (const auto sigma = read_quantity(document(), entry, bound, diagnostics_))
          measurement.inflations.push_back({block.first + static_cast<int>(a), *sigma * *sigma});
      }
    if (!is_found) key_error("B025", entry, "there is no estimated component '" + key + "'" + suggestion(key, names));
  }
}

void Composer::add_withholding(MeasurementPlan& measurement, const std::string& pointer) {
  const std::string withhold_pointer = join_pointer(pointer, "withhold");
  const auto* withhold = at(withhold_pointer);
  if (!withhold) return;
  if (withhold->is_object()) {
    check_keys(document(), withhold_pointer, {"every", "windows"}, "'withhold'", diagnostics_);
    if (withhold->contains("every")) {
      auto spec = parameter::integer("every");
      spec.minimum = 1;
      if (const auto every = read_integer(document(), join_pointer(withhold_pointer, "every"), spec, diagnostics_))
        measurement.withhold_every = static_cast<int>(*every);
    }
  }
  const std::string windows_pointer =
      withhold->is_object() ? join_pointer(withhold_pointer, "windows") : withhold_pointer;
  if (!at(windows_pointer)) return;
  const auto* windows = array_at(document(), windows_pointer, "'withhold'", diagnostics_);
  if (!windows) return;
  for (std::size_t i = 0; i < windows->size(); ++i)
    if (const auto window = read_window(document(), join_pointer(windows_pointer, i), diagnostics_))
      measurement.withheld.push_back(
          TimeSpan{window->from.time, window->to.time, window->from.from_start, window->to.from_start});
}

}  // namespace binnacle::compose
