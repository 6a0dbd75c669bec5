// SPDX-License-Identifier: Apache-2.0
// State blocks of a filter: which components are estimated, first values and their uncertainty.
#include <algorithm>
#include <limits>

#include "compose/composer.hpp"

namespace binnacle::compose {

namespace {

/// "velocity" of "velocity.ned".
std::string family(const std::string& kind) { return kind.substr(0, kind.find_first_of(".:")); }

}  // namespace

void Composer::begin_filters() {
  const auto* filters = object_at(document(), "/filters", "'filters'", diagnostics_);
  if (!filters || filters->empty()) {
    if (!at("/filters")) key_error("B010", "", "the config has no 'filters'; there is nothing to run");
    return;
  }
  for (const auto& [name, value] : filters->items()) {
    const std::string pointer = join_pointer("/filters", name);
    if (!object_at(document(), pointer, "a filter", diagnostics_)) continue;
    check_section_keys(pointer, {"blocks", "derived", "process", "measurements"}, "filter '" + name + "'");
    FilterBuild build;
    build.pointer = pointer;
    build.plan = planned<FilterPlan>(name, pointer);
    const std::string blocks_pointer = join_pointer(pointer, "blocks");
    const auto* blocks = object_at(document(), blocks_pointer, "'blocks'", diagnostics_);
    if (!blocks || blocks->empty()) {
      key_error("B010", pointer, "filter '" + name + "' has no 'blocks'");
      build.is_complete = false;
    } else {
      for (const auto& [block, description] : blocks->items())
        add_block(build, block, join_pointer(blocks_pointer, block));
    }
    publish_estimates(build);
    builds_.push_back(std::move(build));
  }
}

void Composer::add_block(FilterBuild& build, const std::string& name, const std::string& pointer) {
  const std::size_t errors = error_count();
  auto block = planned<BlockPlan>(name, pointer);
  const Component component =
      read_component(Role::state_block, name, pointer, {"type", "init", "sigma", "estimate", "consider", "hold"});
  if (component.is_whole) block.block = make<StateBlock>(component);
  const auto kind = canonical_kind(block.block ? block.declaration().kind : "*");
  if (!kind) error("B030", pointer, kind.error());
  if (!block.block || !kind) {
    build.failed_values.insert(name);
    build.blocks_complete = build.is_complete = false;
    return;
  }
  block.type = component.type->full_name();
  const auto& declaration = block.declaration();
  build.values.push_back({name, *kind, declaration.dof(), declaration.stored_size, declaration.error});
  read_uses(block, pointer);
  block.stored_offset = build.plan.stored_size;
  build.plan.stored_size += declaration.stored_size;
  block.first = build.plan.n;
  build.plan.n += static_cast<int>(block.active.size());
  build.plan.blocks.push_back(std::move(block));
  if (error_count() != errors) build.is_complete = false;
}

void Composer::read_uses(BlockPlan& block, const std::string& pointer) {
  const auto& components = block.declaration().error;
  const auto names = names_of(components);
  const std::string what = "block '" + block.name + "'";
  const auto indices = [&](const char* key) -> std::optional<std::vector<int>> {
    const std::string key_pointer = join_pointer(pointer, key);
    const auto* value = at(key_pointer);
    if (!value) return std::nullopt;
    std::vector<int> found;
    if (value->is_boolean()) {
      if (value->get<bool>())
        for (int i = 0; i < static_cast<int>(components.size()); ++i) found.push_back(i);
      return found;
    }
    if (value->is_array() && value->empty()) return found;
    const auto listed_names = read_names(document(), key_pointer, diagnostics_);
    if (!listed_names) return found;
    for (const auto& name : *listed_names) {
      const auto position = std::find(names.begin(), names.end(), name);
      if (position == names.end())
        error("B025", key_pointer,
              what + " has no component '" + name + "'" + suggestion(name, names) + " (" + listed(names) + ")");
      else
        found.push_back(static_cast<int>(position - names.begin()));
    }
    return found;
  };
  const auto estimate = indices("estimate");
  const auto consider = indices("consider");
  block.use.assign(components.size(), estimate ? Use::frozen : Use::estimated);
  if (estimate)
    for (const int i : *estimate) block.use[as_size(i)] = Use::estimated;
  if (consider)
    for (const int i : *consider) {
      if (estimate && block.use[as_size(i)] == Use::estimated)
        error("B014", join_pointer(pointer, "consider"),
              "component '" + names[as_size(i)] + "' of " + what + " cannot be both estimated and considered");
      block.use[as_size(i)] = Use::considered;
    }
  for (std::size_t i = 0; i < components.size(); ++i)
    if (block.use[i] != Use::frozen) block.active.push_back(static_cast<int>(i));
  block.holds_frozen = read_bool(document(), join_pointer(pointer, "hold"), diagnostics_).value_or(false);
}

void Composer::read_initial(FilterBuild& build, BlockPlan& block, const std::string& pointer) {
  const std::string init_pointer = join_pointer(pointer, "init");
  const auto* init = at(init_pointer);
  const std::size_t errors = error_count();
  if (init && init->is_object() && init->contains("channel")) {
    read_initial_channel(build, block, init_pointer);
    return;
  }
  std::vector<double> values(block.declaration().outputs.size(), 0.0);
  if (!read_initial_values(block, pointer, values) || error_count() != errors) return;
  block.initial.value.assign(as_size(block.declaration().stored_size), 0.0);
  const Result result = block.block->write(values, block.initial.value);
  if (!result) error("B030", init_pointer, "block '" + block.name + "' refuses its initial value: " + result.reason);
}

bool Composer::read_initial_values(const BlockPlan& block, const std::string& pointer, std::vector<double>& values) {
  const auto& outputs = block.declaration().outputs;
  const bool starts_at_zero = block.declaration().starts_at_zero;
  const auto names = names_of(outputs);
  const std::string what = "block '" + block.name + "'";
  const std::string init_pointer = join_pointer(pointer, "init");
  const auto read = [&](const std::string& value_pointer, const std::string& name, std::size_t output) {
    return read_quantity(document(), value_pointer, parameter::number(name, outputs[output].unit), diagnostics_);
  };
  const auto* init = at(init_pointer);
  if (!init) {
    if (!starts_at_zero)
      key_error("B026", pointer,
                "the initial value of " + what + " is missing: \"init\": {\"" +
                    (names.empty() ? std::string("…") : names.front()) + "\": …} or {\"channel\": …}");
  } else if (init->is_object()) {
    check_keys(document(), init_pointer, names, "'init' of " + what, diagnostics_);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const std::string value_pointer = join_pointer(init_pointer, outputs[i].name);
      if (at(value_pointer)) {
        if (const auto value = read(value_pointer, outputs[i].name, i)) values[i] = *value;
      } else if (!starts_at_zero) {
        key_error("B026", init_pointer, "'" + outputs[i].name + "' of the initial value of " + what + " is missing");
      }
    }
  } else if (init->is_array()) {
    if (init->size() != outputs.size()) {
      error("B013", init_pointer,
            "the initial value of " + what + " has " + std::to_string(outputs.size()) + " elements (" + listed(names) +
                "); found " + std::to_string(init->size()));
      return false;
    }
    for (std::size_t i = 0; i < outputs.size(); ++i)
      if (const auto value = read(join_pointer(init_pointer, i), outputs[i].name, i)) values[i] = *value;
  } else if (outputs.size() == 1 || starts_at_zero) {
    if (const auto value = read(init_pointer, "init", 0)) std::fill(values.begin(), values.end(), *value);
  } else {
    error("B006", init_pointer,
          "the initial value of " + what + " is an object with " + listed(names) + ", or {\"channel\": …}; found " +
              abbreviated(*init));
  }
  return true;
}

void Composer::read_initial_channel(FilterBuild& build, BlockPlan& block, const std::string& init_pointer) {
  check_keys(document(), init_pointer, {"channel", "fields", "max_age", "covariance"},
             "'init' of block '" + block.name + "'", diagnostics_);
  const std::string channel_pointer = join_pointer(init_pointer, "channel");
  const auto name = read_string(document(), channel_pointer, diagnostics_);
  if (!name) return;
  bool is_told = false;
  const int channel = channel_named(*name, channel_pointer, is_told);
  if (channel < 0) {
    build.is_complete = false;
    return;
  }
  std::vector<FieldSpec> wanted;
  for (const auto& output : block.declaration().outputs)
    wanted.push_back({output.name, output.unit, FieldKind::level, false, false, {}});
  FieldMap map;
  if (!map_fields(wanted, channel, init_pointer, channel_pointer, block.type, map)) return;
  for (const auto& item : map.epoch) block.initial.fields.push_back(item.index);
  const Time max_age = read_time(document(), join_pointer(init_pointer, "max_age"), diagnostics_).value_or(0);
  const auto [entry, is_new] = build.initial_channels.emplace(*name, static_cast<int>(build.plan.initial.size()));
  if (is_new) build.plan.initial.push_back(LatestPlan{channel, max_age, {}, {}});
  block.initial.channel = entry->second;
  auto& latest = build.plan.initial[as_size(entry->second)];
  if (max_age > 0) latest.max_age = latest.max_age == 0 ? max_age : std::min(latest.max_age, max_age);
  find_initial_covariance(block, channel, join_pointer(init_pointer, "covariance"));
}

// Which components of the sample's covariance are this block's: "BLOCK.north", "position.north" or "north".
void Composer::find_initial_covariance(BlockPlan& block, int channel, const std::string& covariance_pointer) {
  const auto& declaration = block.declaration();
  const auto names = names_of(plan_->channels[as_size(channel)].declaration.covariance);
  if (names.empty()) return;
  const auto wanted_names =
      read_names(document(), covariance_pointer, diagnostics_).value_or(std::vector<std::string>());
  for (std::size_t c = 0; c < declaration.error.size(); ++c) {
    const std::string& component = declaration.error[c].name;
    std::vector<std::string> candidates{block.name + "." + component, family(declaration.kind) + "." + component,
                                        component};
    if (c < wanted_names.size()) candidates = {wanted_names[c]};
    auto found = names.end();
    for (const auto& candidate : candidates)
      if (found == names.end()) found = std::find(names.begin(), names.end(), candidate);
    if (found == names.end()) {
      block.initial.covariance.clear();
      return;
    }
    block.initial.covariance.push_back(static_cast<int>(found - names.begin()));
  }
}

void Composer::read_sigma(FilterBuild& build, BlockPlan& block, const std::string& pointer) {
  const auto& components = block.declaration().error;
  const auto names = names_of(components);
  const std::string sigma_pointer = join_pointer(pointer, "sigma");
  const auto* sigma = at(sigma_pointer);
  const std::string what = "block '" + block.name + "'";
  auto& values = block.initial.sigma;
  values.assign(components.size(), std::numeric_limits<double>::quiet_NaN());
  const auto read = [&](const std::string& value_pointer, std::size_t i) {
    const auto spec = parameter::number("sigma", components[i].unit).at_least(0);
    if (const auto value = read_quantity(document(), value_pointer, spec, diagnostics_)) values[i] = *value;
  };
  if (sigma && sigma->is_object()) {
    check_keys(document(), sigma_pointer, names, "'sigma' of " + what, diagnostics_);
    for (std::size_t i = 0; i < components.size(); ++i)
      if (sigma->contains(names[i])) read(join_pointer(sigma_pointer, names[i]), i);
  } else if (sigma && sigma->is_array()) {
    if (sigma->size() != components.size()) {
      error("B013", sigma_pointer,
            "'sigma' of " + what + " has " + std::to_string(components.size()) + " elements (" + listed(names) +
                "); found " + std::to_string(sigma->size()));
      build.is_complete = false;
      return;
    }
    for (std::size_t i = 0; i < components.size(); ++i) read(join_pointer(sigma_pointer, i), i);
  } else if (sigma) {
    for (std::size_t i = 0; i < components.size(); ++i) read(sigma_pointer, i);
  }
  // A channel that could not be found is reported already.
  if (block.initial.channel < 0 && at(join_pointer(join_pointer(pointer, "init"), "channel"))) return;
  const bool from_sample = block.initial.channel >= 0 && !block.initial.covariance.empty();
  for (const int active : block.active) {
    const auto i = as_size(active);
    const bool is_given = sigma && (!sigma->is_object() || sigma->contains(names[i]));
    if (!is_given && !from_sample) {
      key_error(
          "B026", pointer,
          "'sigma' of " + what + " is missing for '" + names[i] + "' (" + components[i].unit + ")" +
              (block.initial.channel >= 0
                   ? ": channel '" +
                         plan_->channels[as_size(build.plan.initial[as_size(block.initial.channel)].channel)].name +
                         "' carries no covariance for it"
                   : std::string()));
      break;
    }
  }
}

void Composer::publish_estimates(FilterBuild& build) {
  if (!build.blocks_complete) {
    failed_components_.insert(build.plan.name);
    return;
  }
  ChannelDeclaration declaration;
  for (const auto& block : build.plan.blocks) {
    for (const auto& output : block.declaration().outputs)
      declaration.fields.push_back(
          {block.name + "." + output.name, output.unit, FieldKind::level, false, false, output.text});
    for (const int active : block.active) {
      const auto& component = block.declaration().error[as_size(active)];
      declaration.covariance.push_back({block.name + "." + component.name, component.unit});
    }
  }
  std::vector<int> indices;
  add_channels(build.plan.name, build.pointer, {declaration}, indices);
  build.plan.output_channel = indices.front();
}

}  // namespace binnacle::compose
