// SPDX-License-Identifier: Apache-2.0
// Measurements of a filter: models and stacks of them, fields, noise, gates, recovery.
#include <algorithm>

#include <boost/math/distributions/chi_squared.hpp>

#include "compose/composer.hpp"

namespace binnacle::compose {

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
  auto measurement = planned<MeasurementPlan>(name, pointer);
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
  build.plan.max_columns = std::max(build.plan.max_columns, static_cast<int>(measurement.columns.size()));
  build.plan.measurements.push_back(std::move(measurement));
  return true;
}

bool Composer::read_part_fields(const MeasurementPlan& measurement, PartPlan& part, Component& component) {
  const ComponentSpec& spec = component.spec();
  // What is wrong with the channel is reported; its missing fields are not the model's to complain of.
  if (measurement.channel < 0) return false;
  const bool is_whole =
      map_fields(spec.fields, measurement.channel, part.pointer, join_pointer(measurement.pointer, "channel"),
                 spec.type, part.fields, mappable_fields(spec));
  component.bind_fields(part.fields);
  return is_whole;
}

bool Composer::reserve_reads(FilterBuild& build, PartPlan& part, const Component& component) {
  const auto& declaration = part.model->declaration();
  if (declaration.max_rows < 1) error("B030", part.pointer, "'" + component.spec().type + "' declares no rows");
  if (declaration.max_rows < 1 || !reads_bound_ports(declaration.read_ports, component)) return false;
  for (const int port : declaration.read_ports) {
    const int value = part.ports[as_size(port)];
    const int dof = build.values[as_size(value)].dof;
    part.reads.push_back({value, dof, build.reserve(as_size(declaration.max_rows * dof)), {}, port});
  }
  return true;
}

bool Composer::add_part(FilterBuild& build, MeasurementPlan& measurement, const std::string& name,
                        const std::string& pointer, const std::vector<std::string>& reserved) {
  const std::size_t errors = error_count();
  auto part = planned<PartPlan>(name, pointer);
  Component component = read_component(Role::measurement_model, name, pointer, reserved, &build);
  if (!component.type) return false;
  part.type = component.type->full_name();
  part.ports = component.values;
  part.driving_rates = component.driving_rates;
  bool is_whole = read_part_fields(measurement, part, component) && component.is_whole;
  is_whole = read_auxiliary(build, part.auxiliary, component) && is_whole;
  if (!is_whole || error_count() != errors) return false;
  component.covariances = {plan_->channels[as_size(measurement.channel)].declaration.covariance};
  part.model = make<MeasurementModel>(component);
  if (!part.model || !reserve_reads(build, part, component)) return false;
  measurement.max_rows += part.model->declaration().max_rows;
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
    first_column[block] = static_cast<int>(measurement.columns.size());
    const auto& plan = build.plan.blocks[as_size(block)];
    for (std::size_t a = 0; a < plan.active.size(); ++a)
      measurement.columns.push_back(plan.first + static_cast<int>(a));
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
  const auto spec = parameter::number("gate", "1").about("probability").above(0).below(1);
  if (const auto probability = read_quantity(document(), probability_pointer, spec, diagnostics_))
    measurement.gate = *probability;
}

void Composer::add_noise(FilterBuild& build, MeasurementPlan& measurement, const std::string& pointer) {
  const std::string noise_pointer = join_pointer(pointer, "noise");
  if (!at(noise_pointer)) return;
  const Component component =
      read_component(Role::noise_estimator, measurement.name, noise_pointer, {"type", "learn_from_gated"});
  const std::size_t errors = error_count();
  measurement.learn_from_gated =
      read_bool(document(), join_pointer(noise_pointer, "learn_from_gated"), diagnostics_).value_or(false);
  if (!component.type) build.is_complete = false;
  if (!component.is_whole || error_count() != errors) return;
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
  measurement.noise_type = component.type->full_name();
  measurement.noise = make<NoiseEstimator>(component, binding);
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
  const auto spec = parameter::integer("after").at_least(1);
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
        const auto bound = parameter::number(key, component.unit).at_least(0);
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
  std::string windows_pointer = withhold_pointer;
  if (withhold->is_object()) {
    check_keys(document(), withhold_pointer, {"every", "windows"}, "'withhold'", diagnostics_);
    const auto spec = parameter::integer("every").at_least(1);
    if (const auto every = read_integer(document(), join_pointer(withhold_pointer, "every"), spec, diagnostics_))
      measurement.withhold_every = static_cast<int>(*every);
    windows_pointer = join_pointer(withhold_pointer, "windows");
  }
  const auto* windows = array_at(document(), windows_pointer, "'withhold'", diagnostics_);
  if (!windows) return;
  for (std::size_t i = 0; i < windows->size(); ++i)
    if (const auto window = read_window(document(), join_pointer(windows_pointer, i), diagnostics_))
      measurement.withheld.push_back(
          TimeSpan{window->from.time, window->to.time, window->from.from_start, window->to.from_start});
}

}  // namespace binnacle::compose
