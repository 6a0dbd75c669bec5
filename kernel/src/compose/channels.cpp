// SPDX-License-Identifier: Apache-2.0
// Sources, transforms, sinks, and how components find the fields they want on channels.
#include <algorithm>

#include "compose/identity.hpp"

namespace binnacle::internal::compose {

namespace {

constexpr const char* kind_names[] = {"level", "rate", "increment"};  // as FieldKind counts them

/// Whether the channel is one of the component's.
bool is_of(const std::string& channel, const std::string& component) {
  return channel == component || channel.starts_with(component + ".");
}

Dimension dimension_of(const std::string& unit) {
  const auto parsed = parse_unit(unit);
  return parsed ? parsed->dimension : Dimension{};
}

/// Why a channel's field cannot serve as the wanted one; empty: it can, with that conversion.
std::string misfit(const FieldSpec& wanted, const FieldSpec& found, const ChannelPlan& channel, const std::string& type,
                   FieldMap::Conversion& conversion) {
  const Dimension carried = dimension_of(found.unit.empty() ? "1" : found.unit), second = dimension_of("s");
  const Dimension need = dimension_of(takes_any_unit(wanted) ? "1" : wanted.unit);
  Dimension have = carried;
  const std::string what = "field '" + found.name + "' of channel '" + channel.name + "'";
  const std::string needs = "; '" + type + "' needs ";
  if (wanted.kind == FieldKind::rate && found.kind == FieldKind::increment) {
    conversion = FieldMap::Conversion::to_rate;
    have = have / second;
  } else if (wanted.kind == FieldKind::increment && found.kind == FieldKind::rate) {
    conversion = FieldMap::Conversion::to_increment;
    have = have * second;
  } else if ((wanted.kind != FieldKind::level && found.kind == FieldKind::level) ||
             (wanted.kind == FieldKind::level && found.kind == FieldKind::increment)) {
    return what + " is a " + kind_names[static_cast<int>(found.kind)] + needs + "a " +
           kind_names[static_cast<int>(wanted.kind)] + "; if it is one, say \"kind\": \"rate\" or \"increment\" in " +
           (channel.pointer.empty() ? "its source" : channel.pointer);
  }
  if (!takes_any_unit(wanted) && have != need) {
    const auto as = [&](const char* words, FieldKind kind) {
      if (conversion == FieldMap::Conversion::none) return std::string();
      return words + std::string(kind == FieldKind::rate ? "a rate" : "an increment");
    };
    return what + " is " + dimension_name(carried) + as(" and said to be ", found.kind) + needs + dimension_name(need) +
           as(" as ", wanted.kind);
  }
  if (found.is_per_row == wanted.is_per_row) return {};
  return what + " has " + (found.is_per_row ? "one value per row" : "one value per sample") + needs +
         (wanted.is_per_row ? "one per row" : "one per sample");
}

}  // namespace

std::vector<int> Composer::add_channels(const Reader& component, const std::vector<ChannelDeclaration>& declarations) {
  std::vector<int> indices;
  for (const auto& declaration : declarations) {
    ChannelPlan channel;
    channel.name = declaration.name.empty() ? component.key() : component.key() + "." + declaration.name;
    channel.pointer = component.pointer();
    channel.declaration = declaration;
    for (const auto& field : declaration.fields)
      channel.position.push_back(field.is_per_row ? channel.row_fields++ : channel.epoch_fields++);
    channel.covariance_dof = count_of(declaration.covariance);
    indices.push_back(count_of(plan_->channels));
    if (plan_->channel(channel.name) >= 0)
      component.key_error("B002", "channel '" + channel.name + "' is emitted twice; rename this component");
    plan_->channels.push_back(std::move(channel));
  }
  return indices;
}

int Composer::channel_named(const std::string& name, const Reader& at) {
  const int index = plan_->channel(name);
  if (index >= 0) return index;
  fail();
  if (std::ranges::any_of(failed_components_, [&](const std::string& failed) { return is_of(name, failed); }))
    return -1;
  const auto names = names_of(plan_->channels);
  at.error("B020", "there is no channel '" + name + "'" + suggestion(name, names) +
                       (names.empty() ? "" : " (channels: " + listed(names) + ")"));
  return -1;
}

FieldMap Composer::map_fields(const std::vector<FieldSpec>& wanted, int channel_index, const Reader& channel_at,
                              const Reader& at, const std::string& type, const std::vector<FieldSpec>& mappable) {
  const ChannelPlan& its_channel = channel(channel_index);
  const auto& fields = its_channel.declaration.fields;
  const Reader mapping = at["fields"];
  if (mapping.is_object("'fields'")) mapping.check_keys(names_of(mappable), "'fields' of '" + type + "'");
  FieldMap map;
  int declared = 0;
  for (const auto& field : wanted) {
    FieldMap::Item item;
    item.required = !field.is_optional;
    item.declared = declared++;
    const Reader mapped = mapping[field.name];
    const auto name = mapped ? mapped.text() : field.name;
    if (!name) continue;
    const Reader& place = mapped ? mapped : channel_at;
    const int found = index_of(fields, *name, &FieldSpec::name);
    if (found >= 0) {
      const auto why = misfit(field, fields[as_size(found)], its_channel, type, item.conversion);
      if (!why.empty()) {
        place.error("B021", why);
        continue;
      }
      item.index = its_channel.position[as_size(found)];
    } else if (!field.is_optional || mapped) {
      place.error("B021", "channel '" + its_channel.name + "' has no field '" + *name + "'" +
                              (takes_any_unit(field) ? "" : " (" + field.unit + ")") + " that '" + type + "' needs" +
                              suggestion(*name, names_of(fields)) + " (it has " + listed(names_of(fields)) +
                              "; map another with \"fields\": {\"" + field.name + "\": …})");
    }
    (field.is_per_row ? map.row : map.epoch).push_back(item);
  }
  return map;
}

FieldMap Composer::bind_fields(Component& component, const std::vector<FieldSpec>& wanted, int channel,
                               const Reader& channel_at, std::size_t first) {
  const ComponentSpec& spec = component.spec();
  // The one key "fields" may map those of its sample and of all its inputs.
  std::vector<FieldSpec> mappable = spec.fields;
  for (const auto& input : spec.inputs) mappable.insert(mappable.end(), input.fields.begin(), input.fields.end());
  FieldMap map = map_fields(wanted, channel, channel_at, component.at, spec.type, mappable);
  for (const auto* items : {&map.epoch, &map.row})
    for (const auto& item : *items) component.fields_bound[first + as_size(item.declared)] = item.index >= 0;
  return map;
}

namespace {

/// As they stand.
FieldMap all_fields(const ChannelPlan& channel) {
  FieldMap map;
  for (std::size_t i = 0; i < channel.position.size(); ++i)
    (channel.declaration.fields[i].is_per_row ? map.row : map.epoch).push_back({.index = channel.position[i]});
  return map;
}

}  // namespace

std::vector<NodeInput> Composer::read_inputs(Component& component) {
  const ComponentSpec& spec = component.spec();
  const bool is_stage = component.type->role == Role::transform || component.type->role == Role::sink;
  const bool is_single = is_stage && spec.inputs.size() == 1;
  const Reader named = component.at["inputs"], single = component.at["input"];
  if (named.is_object("'inputs'")) named.check_keys(names_of(spec.inputs), "'inputs' of '" + spec.type + "'");
  std::vector<NodeInput> inputs;
  for (const auto& wanted : spec.inputs) {
    NodeInput& input = inputs.emplace_back();
    const bool may_be_single = is_stage && &wanted == &spec.inputs.front();
    const Reader channel_place = named[wanted.name] || !may_be_single ? named[wanted.name] : single;
    if (!channel_place && !wanted.is_optional)
      component.at.key_error("B010", "input '" + wanted.name + "' of '" + spec.type + "' is missing: " +
                                         (is_single ? "\"input\": \"CHANNEL\""
                                                    : "\"inputs\": {\"" + wanted.name + "\": \"CHANNEL\"}"));
    if (const auto name = channel_place.text()) input.channel = channel_named(*name, channel_place);
    const auto first = component.fields_bound.size();
    component.fields_bound.resize(first + wanted.fields.size(), false);
    if (input.channel >= 0)
      input.fields = wanted.is_whole ? all_fields(channel(input.channel))
                                     : bind_fields(component, wanted.fields, input.channel, channel_place, first);
    component.inputs_bound.push_back(input.channel >= 0);
  }
  return inputs;
}

namespace {

void add_files(const ParameterSpec& spec, const ParameterValue& value, std::vector<std::string>& files) {
  if (spec.type == ParameterType::path && !value.text.empty()) files.push_back(value.text);
  for (const auto& element : value.elements) add_files(spec.members.front(), element, files);
  for (const auto& [key, member] : value.members) {
    const int of = spec.type == ParameterType::map ? 0 : index_of(spec.members, key, &ParameterSpec::name);
    if (of >= 0) add_files(spec.members[as_size(of)], member, files);
  }
}

/// False where something is wrong with it; then it is left out.
template <class Base, class Plan>
bool add_stage(Composer& composer, const Reader& at, std::vector<Plan>& stages) {
  constexpr bool has_inputs = !std::is_same_v<Base, Source>;
  std::vector<std::string> reserved{"type"};
  if (std::is_same_v<Base, Source>) reserved.push_back("latency");
  if (has_inputs) reserved.insert(reserved.end(), {"input", "inputs", "fields"});
  auto stage = planned<Plan>(at);
  Component component = composer.read_component(role_of<Base>(), at, reserved);
  stage.type = component.type;
  if (has_inputs && component.type) {
    stage.inputs = composer.read_inputs(component);
    component.covariances.clear();
    for (const auto& input : stage.inputs) {
      const auto* declaration = input.channel < 0 ? nullptr : &composer.channel(input.channel).declaration;
      component.channels.push_back(declaration);
      component.covariances.push_back(declaration ? declaration->covariance : std::vector<NamedUnit>());
    }
  }
  stage.object = composer.make<Base>(component);
  if constexpr (!std::is_same_v<Base, Sink>)
    if (stage.object) stage.channels = composer.add_channels(at, stage.object->declaration().channels);
  if constexpr (std::is_same_v<Base, Source>)
    if (stage.object) {
      stage.latency = read_latency(at["latency"], stage.object->declaration().channels);
      for (const auto& parameter : component.spec().parameters)
        for (const auto& [key, value] : component.parameters.members)
          if (key == parameter.name) add_files(parameter, value, stage.files);
    }
  if (component.failures != composer.failures()) return false;
  stage.identity = identity_of(composer.plan(), component, stage);
  stages.push_back(std::move(stage));
  return true;
}

}  // namespace

void Composer::add_sources() {
  for (const Reader& at : place("/sources").members("'sources'"))
    if (!add_stage<Source>(*this, at, plan_->sources)) fail_component(at.key());
  const bool is_any_live =
      std::ranges::any_of(plan_->sources, [](const auto& source) { return source.object->declaration().live; });
  if (!is_any_live) return;
  for (const auto& source : plan_->sources)
    if (source.latency)
      place(source.pointer + "/latency")
          .error("B010", "'latency' is for recorded data, but a source is live: its samples arrive in real time");
}

void Composer::add_transforms() {
  const Reader transforms = place("/transforms");
  if (!transforms.is_object("'transforms'")) return;
  const auto is_waiting = [&](const Reader& transform, const std::vector<std::string>& open) {
    std::vector<Reader> wanted = transform["inputs"].children();
    for (const char* key : {"input", "inputs"}) wanted.push_back(transform[key]);
    return std::ranges::any_of(wanted, [&](const Reader& place) {
      if (!place || !config::JsonOf::at(place).is_string()) return false;
      const auto& channel = config::JsonOf::at(place).get_ref<const std::string&>();
      return plan_->channel(channel) < 0 && std::ranges::any_of(open, [&](const std::string& other) {
               return is_of(channel, other) || channel == transform.key();
             });
    });
  };
  // A transform can be bound once the channels that it subscribes to are known.
  const auto cycle = in_order(transforms, "these transforms depend on each other in a cycle: ", is_waiting,
                              [&](const Reader& transform) {
                                if (!add_stage<Transform>(*this, transform, plan_->transforms))
                                  fail_component(transform.key());
                              });
  for (const auto& name : cycle) fail_component(name);
}

void Composer::add_sinks() {
  for (const Reader& at : place("/sinks").members("'sinks'")) add_stage<Sink>(*this, at, plan_->sinks);
}

}  // namespace binnacle::internal::compose
