// SPDX-License-Identifier: Apache-2.0
// Sources, transforms, sinks, and how components find the fields they want on channels.
#include <algorithm>

#include "compose/composer.hpp"

namespace binnacle::compose {

namespace {

const char* kind_name(FieldKind kind) {
  switch (kind) {
    case FieldKind::rate: return "rate";
    case FieldKind::increment: return "increment";
    default: return "level";
  }
}

}  // namespace

void Composer::add_channels(const std::string& component, const std::string& pointer,
                            const std::vector<ChannelDeclaration>& declarations, std::vector<int>& indices) {
  for (const auto& declaration : declarations) {
    ChannelPlan channel;
    channel.name = declaration.name.empty() ? component : component + "." + declaration.name;
    channel.pointer = pointer;
    channel.declaration = declaration;
    for (const auto& field : declaration.fields)
      channel.position.push_back(field.is_per_row ? channel.row_fields++ : channel.epoch_fields++);
    channel.covariance_dof = static_cast<int>(declaration.covariance.size());
    indices.push_back(static_cast<int>(plan_->channels.size()));
    if (plan_->channel(channel.name) >= 0)
      key_error("B002", pointer, "channel '" + channel.name + "' is emitted twice; rename this component");
    plan_->channels.push_back(std::move(channel));
  }
}

void Composer::add_sources() {
  const auto* sources = object_at(document(), "/sources", "'sources'", diagnostics_);
  if (!sources) return;
  for (const auto& item : sources->items()) {
    const std::size_t errors = error_count();
    auto source = planned<SourcePlan>(item.key(), join_pointer("/sources", item.key()));
    const Component component = read_component(Role::source, source.name, source.pointer, {"type"});
    source.type = component.type;
    if (component.is_whole)
      source.source = make<Source>(component, {}, [&](const Source& made) {
        add_channels(source.name, source.pointer, made.declaration().channels, source.channels);
      });
    if (error_count() != errors)
      failed_components_.insert(source.name);
    else
      plan_->sources.push_back(std::move(source));
  }
}

int Composer::channel_named(const std::string& name, const std::string& pointer, bool& is_told) {
  const int index = plan_->channel(name);
  if (index >= 0) return index;
  for (const auto& failed : failed_components_)
    if (name == failed || name.rfind(failed + ".", 0) == 0) {
      is_told = true;
      return -1;
    }
  std::vector<std::string> names;
  for (const auto& channel : plan_->channels) names.push_back(channel.name);
  error("B020", pointer,
        "there is no channel '" + name + "'" + suggestion(name, names) +
            (names.empty() ? "" : " (channels: " + listed(names) + ")"));
  is_told = true;
  return -1;
}

bool Composer::fits(const FieldSpec& wanted, const FieldSpec& found, const ChannelPlan& channel,
                    const std::string& pointer, const std::string& type, FieldMap::Conversion& conversion) {
  const auto carried = parse_unit(found.unit.empty() ? "1" : found.unit);
  const auto needed = parse_unit(takes_any_unit(wanted) ? "1" : wanted.unit);
  Dimension have = carried ? carried->dimension : Dimension{};
  const Dimension need = needed ? needed->dimension : Dimension{};
  const Dimension second = parse_unit("s")->dimension;
  const std::string what = "field '" + found.name + "' of channel '" + channel.name + "'";
  if (wanted.kind == FieldKind::rate && found.kind == FieldKind::increment) {
    conversion = FieldMap::Conversion::to_rate;
    have = have / second;
  } else if (wanted.kind == FieldKind::increment && found.kind == FieldKind::rate) {
    conversion = FieldMap::Conversion::to_increment;
    have = have * second;
  } else if ((wanted.kind != FieldKind::level && found.kind == FieldKind::level) ||
             (wanted.kind == FieldKind::level && found.kind == FieldKind::increment)) {
    error("B021", pointer,
          what + " is a " + kind_name(found.kind) + "; '" + type + "' needs a " + kind_name(wanted.kind) +
              "; if it is one, say \"kind\": \"rate\" or \"increment\" in " +
              (channel.pointer.empty() ? std::string("its source") : channel.pointer));
    return false;
  }
  if (!takes_any_unit(wanted) && !(have == need)) {
    const auto as = [&](const char* words, FieldKind kind) {
      if (conversion == FieldMap::Conversion::none) return std::string();
      return words + std::string(kind == FieldKind::rate ? "a rate" : "an increment");
    };
    error("B021", pointer,
          what + " is " + dimension_name(carried->dimension) + as(" and said to be ", found.kind) + "; '" + type +
              "' needs " + dimension_name(need) + as(" as ", wanted.kind));
    return false;
  }
  if (found.is_per_row != wanted.is_per_row) {
    error("B021", pointer,
          what + " has " + (found.is_per_row ? "one value per row" : "one value per sample") + "; '" + type +
              "' needs " + (wanted.is_per_row ? "one per row" : "one per sample"));
    return false;
  }
  return true;
}

bool Composer::map_fields(const std::vector<FieldSpec>& wanted, int channel_index, const std::string& component_pointer,
                          const std::string& channel_pointer, const std::string& type, FieldMap& map,
                          const std::vector<FieldSpec>& mappable) {
  const auto& channel = plan_->channels[as_size(channel_index)];
  const auto& fields = channel.declaration.fields;
  const std::string mapping_pointer = join_pointer(component_pointer, "fields");
  const auto* mapping = object_at(document(), mapping_pointer, "'fields'", diagnostics_);
  const std::size_t errors = error_count();
  if (mapping)
    check_keys(document(), mapping_pointer, names_of(mappable.empty() ? wanted : mappable),
               "'fields' of '" + type + "'", diagnostics_);
  int declared = 0;
  for (const auto& field : wanted) {
    FieldMap::Item item;
    item.required = !field.is_optional;
    item.declared = declared++;
    std::string name = field.name;
    const bool is_mapped = mapping && mapping->contains(field.name);
    if (is_mapped) {
      const auto text = read_string(document(), join_pointer(mapping_pointer, field.name), diagnostics_);
      if (!text) continue;
      name = *text;
    }
    const auto found = std::find_if(fields.begin(), fields.end(), [&](const FieldSpec& f) { return f.name == name; });
    const std::string at_pointer = is_mapped ? join_pointer(mapping_pointer, field.name) : channel_pointer;
    if (found != fields.end()) {
      if (!fits(field, *found, channel, at_pointer, type, item.conversion)) continue;
      item.index = channel.position[static_cast<std::size_t>(found - fields.begin())];
    } else if (!field.is_optional || is_mapped) {
      error("B021", at_pointer,
            "channel '" + channel.name + "' has no field '" + name + "'" +
                (takes_any_unit(field) ? std::string() : " (" + field.unit + ")") + " that '" + type + "' needs" +
                suggestion(name, names_of(fields)) + " (it has " + listed(names_of(fields)) +
                "; map another with \"fields\": {\"" + field.name + "\": …})");
    }
    (field.is_per_row ? map.row : map.epoch).push_back(item);
  }
  return error_count() == errors;
}

std::vector<FieldSpec> mappable_fields(const ComponentSpec& spec) {
  std::vector<FieldSpec> fields = spec.fields;
  for (const auto& input : spec.inputs) fields.insert(fields.end(), input.fields.begin(), input.fields.end());
  return fields;
}

bool Composer::read_inputs(Component& component, std::vector<NodeInput>& inputs) {
  const std::size_t errors = error_count();
  const ComponentSpec& spec = component.spec();
  const std::string& pointer = component.pointer;
  const bool is_stage = component.type->role == Role::transform || component.type->role == Role::sink;
  const bool is_single = is_stage && spec.inputs.size() == 1;
  const std::string inputs_pointer = join_pointer(pointer, "inputs");
  const auto* named = object_at(document(), inputs_pointer, "'inputs'", diagnostics_);
  const bool has_single = is_stage && at(join_pointer(pointer, "input")) != nullptr;
  if (named)
    check_keys(document(), inputs_pointer, names_of(spec.inputs), "'inputs' of '" + spec.type + "'", diagnostics_);
  bool is_told = false;
  const std::vector<FieldSpec> mappable = mappable_fields(spec);
  for (const auto& wanted : spec.inputs) {
    NodeInput input;
    std::string channel_pointer;
    if (named && named->contains(wanted.name)) {
      channel_pointer = join_pointer(inputs_pointer, wanted.name);
    } else if (has_single && (is_single || &wanted == &spec.inputs.front())) {
      channel_pointer = join_pointer(pointer, "input");
    } else if (!wanted.is_optional) {
      key_error("B010", pointer,
                "input '" + wanted.name + "' of '" + spec.type + "' is missing: " +
                    (is_single ? "\"input\": \"CHANNEL\"" : "\"inputs\": {\"" + wanted.name + "\": \"CHANNEL\"}"));
    }
    if (!channel_pointer.empty())
      if (const auto name = read_string(document(), channel_pointer, diagnostics_)) {
        input.channel = channel_named(*name, channel_pointer, is_told);
        if (input.channel >= 0)
          map_fields(wanted.fields, input.channel, pointer, channel_pointer, spec.type, input.fields, mappable);
      }
    const auto first = component.fields_bound.size();
    component.fields_bound.resize(first + wanted.fields.size(), false);
    component.bind_fields(input.fields, first);
    component.inputs_bound.push_back(input.channel >= 0);
    inputs.push_back(std::move(input));
  }
  return error_count() == errors && !is_told;
}

Component Composer::read_stage(Role role, const std::string& name, const std::string& pointer,
                               std::vector<NodeInput>& inputs) {
  Component component = read_component(role, name, pointer, {"type", "input", "inputs", "fields"});
  if (!component.type) return component;
  component.is_whole = read_inputs(component, inputs) && component.is_whole;
  component.covariances.assign(inputs.size(), {});
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (inputs[i].channel >= 0)
      component.covariances[i] = plan_->channels[as_size(inputs[i].channel)].declaration.covariance;
  return component;
}

bool Composer::add_transform(const std::string& name, const std::string& pointer) {
  const std::size_t errors = error_count();
  auto transform = planned<TransformPlan>(name, pointer);
  const Component component = read_stage(Role::transform, name, pointer, transform.inputs);
  transform.type = component.type;
  if (component.is_whole)
    transform.transform = make<Transform>(component, {}, [&](const Transform& made) {
      add_channels(name, pointer, made.declaration().channels, transform.channels);
    });
  if (!transform.transform || error_count() != errors) return false;
  plan_->transforms.push_back(std::move(transform));
  return true;
}

void Composer::add_transforms() {
  const auto* transforms = object_at(document(), "/transforms", "'transforms'", diagnostics_);
  if (!transforms) return;
  const auto is_of = [](const std::string& channel, const std::string& transform) {
    return channel == transform || channel.rfind(transform + ".", 0) == 0;
  };
  const auto is_waiting = [&](const std::string& name, const std::vector<std::string>& open) {
    std::vector<std::string> wanted;
    for (const char* key : {"input", "inputs"})
      if (const auto* value = at(join_pointer(join_pointer("/transforms", name), key))) {
        if (value->is_string()) wanted.push_back(value->get<std::string>());
        if (value->is_object())
          for (const auto& channel : *value)
            if (channel.is_string()) wanted.push_back(channel.get<std::string>());
      }
    return std::any_of(wanted.begin(), wanted.end(), [&](const std::string& channel) {
      return plan_->channel(channel) < 0 && std::any_of(open.begin(), open.end(), [&](const std::string& other) {
               return is_of(channel, other) || channel == name;
             });
    });
  };
  // A transform can be bound once the channels that it subscribes to are known.
  const auto cycle = in_order("/transforms", "these transforms feed each other: ", is_waiting,
                              [&](const std::string& name, const std::string& pointer) {
                                if (!add_transform(name, pointer)) failed_components_.insert(name);
                              });
  failed_components_.insert(cycle.begin(), cycle.end());
}

void Composer::add_sinks() {
  const auto* sinks = object_at(document(), "/sinks", "'sinks'", diagnostics_);
  if (!sinks) return;
  for (const auto& item : sinks->items()) {
    auto sink = planned<SinkPlan>(item.key(), join_pointer("/sinks", item.key()));
    const Component component = read_stage(Role::sink, sink.name, sink.pointer, sink.inputs);
    sink.type = component.type;
    if (component.is_whole) sink.sink = make<Sink>(component);
    if (sink.sink) plan_->sinks.push_back(std::move(sink));
  }
}

}  // namespace binnacle::compose
