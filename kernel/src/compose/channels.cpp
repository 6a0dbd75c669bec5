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
  for (const auto& [name, value] : sources->items()) {
    const std::string pointer = join_pointer("/sources", name);
    const std::size_t errors = error_count();
    SourcePlan source;
    source.name = name;
    source.pointer = pointer;
    source.type = type_of(Role::source, pointer);
    if (source.type) {
      const auto parameters = check_parameters(source.type->spec.parameters, source.type->spec.type, document(),
                                               pointer, {"type"}, {}, diagnostics_);
      if (error_count() == errors)
        guarded(pointer, [&, &name = name](Findings& findings) {
          source.source = source.type->create_source(
              Binding(name, Parameters(parameters), {}, {}).of(source.type->spec).telling(findings));
          add_channels(name, pointer, source.source->channels(), source.channels);
        });
    }
    if (error_count() != errors) {
      failed_components_.insert(name);
      continue;
    }
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

bool Composer::map_fields(const std::vector<FieldSpec>& wanted, int channel_index, const std::string& component_pointer,
                          const std::string& channel_pointer, const std::string& type, FieldMap& map,
                          const std::vector<FieldSpec>& mappable) {
  const auto& channel = plan_->channels[static_cast<std::size_t>(channel_index)];
  const auto& fields = channel.declaration.fields;
  const std::string mapping_pointer = join_pointer(component_pointer, "fields");
  const auto* mapping = object_at(document(), mapping_pointer, "'fields'", diagnostics_);
  const std::size_t errors = error_count();
  if (mapping) {
    std::vector<std::string> allowed;
    for (const auto& field : mappable.empty() ? wanted : mappable) allowed.push_back(field.name);
    check_keys(document(), mapping_pointer, allowed, "'fields' of '" + type + "'", diagnostics_);
  }
  int declared = 0;
  for (const auto& field : wanted) {
    FieldMap::Item item;
    item.required = !field.is_optional;
    item.declared = declared++;
    map.names.push_back(field.name);
    std::string name = field.name;
    const bool is_mapped = mapping && mapping->contains(field.name);
    if (is_mapped) {
      const auto text = read_string(document(), join_pointer(mapping_pointer, field.name), diagnostics_);
      if (!text) continue;
      name = *text;
    }
    const auto found = std::find_if(fields.begin(), fields.end(), [&](const FieldSpec& f) { return f.name == name; });
    const std::string at_pointer = is_mapped ? join_pointer(mapping_pointer, field.name) : channel_pointer;
    if (found == fields.end()) {
      if (!field.is_optional || is_mapped)
        error("B021", at_pointer,
              "channel '" + channel.name + "' has no field '" + name + "'" +
                  (takes_any_unit(field) ? std::string() : " (" + field.unit + ")") + " that '" + type + "' needs" +
                  suggestion(name, names_of(channel.declaration.fields)) + " (it has " +
                  listed(names_of(channel.declaration.fields)) + "; map another with \"fields\": {\"" + field.name +
                  "\": …})");
    } else {
      const auto carried = parse_unit(found->unit.empty() ? "1" : found->unit);
      const auto needed = parse_unit(takes_any_unit(field) ? "1" : field.unit);
      Dimension have = carried ? carried->dimension : Dimension{};
      const Dimension need = needed ? needed->dimension : Dimension{};
      const Dimension second = parse_unit("s")->dimension;
      bool kind_fits = true;
      if (field.kind == FieldKind::rate && found->kind == FieldKind::increment) {
        item.conversion = FieldMap::Conversion::to_rate;
        have = have / second;
      } else if (field.kind == FieldKind::increment && found->kind == FieldKind::rate) {
        item.conversion = FieldMap::Conversion::to_increment;
        have = have * second;
      } else if (field.kind != FieldKind::level && found->kind == FieldKind::level) {
        kind_fits = false;
      } else if (field.kind == FieldKind::level && found->kind == FieldKind::increment) {
        kind_fits = false;
      }
      if (!kind_fits) {
        error("B021", at_pointer,
              "field '" + name + "' of channel '" + channel.name + "' is a " + kind_name(found->kind) + "; '" + type +
                  "' needs a " + kind_name(field.kind) + "; if it is one, say \"kind\": \"rate\" or \"increment\" in " +
                  (channel.pointer.empty() ? std::string("its source") : channel.pointer));
        continue;
      }
      if (!takes_any_unit(field) && !(have == need)) {
        const bool is_converted = item.conversion != FieldMap::Conversion::none;
        error("B021", at_pointer,
              "field '" + name + "' of channel '" + channel.name + "' is " + dimension_name(carried->dimension) +
                  (is_converted
                       ? std::string(" and said to be ") + (found->kind == FieldKind::rate ? "a rate" : "an increment")
                       : std::string()) +
                  "; '" + type + "' needs " + dimension_name(need) +
                  (is_converted ? std::string(" as ") + (field.kind == FieldKind::rate ? "a rate" : "an increment")
                                : std::string()));
        continue;
      }
      if (found->is_per_row != field.is_per_row) {
        error("B021", at_pointer,
              "field '" + name + "' of channel '" + channel.name + "' has " +
                  (found->is_per_row ? "one value per row" : "one value per sample") + "; '" + type + "' needs " +
                  (field.is_per_row ? "one per row" : "one per sample"));
        continue;
      }
      item.index = channel.position[static_cast<std::size_t>(found - fields.begin())];
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

bool Composer::read_inputs(const ComponentSpec& spec, const std::string& pointer, std::vector<NodeInput>& inputs) {
  const std::size_t errors = error_count();
  const bool is_single = spec.inputs.size() == 1;
  const std::string inputs_pointer = join_pointer(pointer, "inputs");
  const auto* named = object_at(document(), inputs_pointer, "'inputs'", diagnostics_);
  const bool has_single = at(join_pointer(pointer, "input")) != nullptr;
  std::vector<std::string> names;
  for (const auto& input : spec.inputs) names.push_back(input.name);
  if (named) check_keys(document(), inputs_pointer, names, "'inputs' of '" + spec.type + "'", diagnostics_);
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
    inputs.push_back(std::move(input));
  }
  return error_count() == errors && !is_told;
}

void Composer::add_transforms() {
  const auto* transforms = object_at(document(), "/transforms", "'transforms'", diagnostics_);
  if (!transforms) return;
  // In rounds: a transform can be bound once the channels that it listens to are known.
  std::vector<std::string> waiting;
  for (const auto& [name, value] : transforms->items()) waiting.push_back(name);
  const auto is_pending = [&](const std::string& pointer, const std::string& self) {
    std::vector<std::string> wanted;
    for (const char* key : {"input", "inputs"})
      if (const auto* value = at(join_pointer(pointer, key))) {
        if (value->is_string()) wanted.push_back(value->get<std::string>());
        if (value->is_object())
          for (const auto& [port, channel] : value->items())
            if (channel.is_string()) wanted.push_back(channel.get<std::string>());
      }
    return std::any_of(wanted.begin(), wanted.end(), [&](const std::string& channel) {
      return plan_->channel(channel) < 0 && std::any_of(waiting.begin(), waiting.end(), [&](const std::string& other) {
               return channel == other || channel.rfind(other + ".", 0) == 0 || (channel == self);
             });
    });
  };
  while (!waiting.empty()) {
    std::vector<std::string> later;
    bool has_progress = false;
    for (const auto& name : waiting) {
      const std::string pointer = join_pointer("/transforms", name);
      if (is_pending(pointer, name)) {
        later.push_back(name);
        continue;
      }
      has_progress = true;
      const std::size_t errors = error_count();
      bool is_bound = true;
      TransformPlan transform;
      transform.name = name;
      transform.pointer = pointer;
      transform.type = type_of(Role::transform, pointer);
      if (transform.type) {
        const auto parameters = check_parameters(transform.type->spec.parameters, transform.type->spec.type, document(),
                                                 pointer, {"type", "input", "inputs", "fields"}, {}, diagnostics_);
        is_bound = read_inputs(transform.type->spec, pointer, transform.inputs);
        if (error_count() == errors && is_bound) {
          std::vector<PortBinding> inputs;
          std::vector<bool> fields_bound, inputs_bound;
          std::vector<std::vector<NamedUnit>> covariances(transform.inputs.size());
          for (std::size_t i = 0; i < transform.inputs.size(); ++i) {
            PortBinding input;
            input.name = transform.type->spec.inputs[i].name;
            input.bound = transform.inputs[i].channel >= 0;
            inputs.push_back(input);
            inputs_bound.push_back(input.bound);
            if (input.bound)
              covariances[i] =
                  plan_->channels[static_cast<std::size_t>(transform.inputs[i].channel)].declaration.covariance;
            const auto first = fields_bound.size();
            fields_bound.resize(first + transform.type->spec.inputs[i].fields.size(), false);
            for (const auto* items : {&transform.inputs[i].fields.epoch, &transform.inputs[i].fields.row})
              for (const auto& item : *items)
                fields_bound[first + static_cast<std::size_t>(item.declared)] = item.index >= 0;
          }
          guarded(pointer, [&](Findings& findings) {
            transform.transform = transform.type->create_transform(
                Binding(name, Parameters(parameters), inputs, fields_bound, 1, covariances)
                    .of(transform.type->spec, inputs_bound)
                    .telling(findings));
            add_channels(name, pointer, transform.transform->channels(), transform.channels);
          });
        }
      }
      if (error_count() != errors || !is_bound || !transform.transform) {
        failed_components_.insert(name);
        continue;
      }
      plan_->transforms.push_back(std::move(transform));
    }
    if (!has_progress) {
      error("B023", join_pointer("/transforms", later.front()), "these transforms feed each other: " + listed(later));
      for (const auto& name : later) failed_components_.insert(name);
      return;
    }
    waiting = later;
  }
}

void Composer::add_sinks() {
  const auto* sinks = object_at(document(), "/sinks", "'sinks'", diagnostics_);
  if (!sinks) return;
  for (const auto& [name, value] : sinks->items()) {
    const std::string pointer = join_pointer("/sinks", name);
    const std::size_t errors = error_count();
    SinkPlan sink;
    sink.name = name;
    sink.pointer = pointer;
    sink.type = type_of(Role::sink, pointer);
    if (!sink.type) continue;
    const auto parameters = check_parameters(sink.type->spec.parameters, sink.type->spec.type, document(), pointer,
                                             {"type", "input", "inputs", "fields"}, {}, diagnostics_);
    const bool is_bound = read_inputs(sink.type->spec, pointer, sink.inputs);
    if (error_count() != errors || !is_bound) continue;
    guarded(pointer, [&, &name = name](Findings& findings) {
      sink.sink =
          sink.type->create_sink(Binding(name, Parameters(parameters), {}, {}).of(sink.type->spec).telling(findings));
    });
    if (sink.sink) plan_->sinks.push_back(std::move(sink));
  }
}

}  // namespace binnacle::compose
