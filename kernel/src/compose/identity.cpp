// SPDX-License-Identifier: Apache-2.0
#include "compose/identity.hpp"

#include <type_traits>

namespace binnacle::internal::compose {

namespace {

/// Values one after the other; of what varies in length, the length first.
class Bytes {
 public:
  template <class Number>
  requires std::is_arithmetic_v<Number>
  void add(Number number) { text_.append(reinterpret_cast<const char*>(&number), sizeof number); }
  void add(const std::string& text) {
    add(text.size());
    text_ += text;
  }
  void add(const ParameterValue& value) {
    add(static_cast<int>(value.type));
    add(value.boolean);
    add(value.integer);
    add(value.number);
    add(value.text);
    add(value.rows);
    add(value.cols);
    add(value.numbers.size());
    for (const double number : value.numbers) add(number);
    add(value.elements.size());
    for (const auto& element : value.elements) add(element);
    add(value.members.size());
    for (const auto& [key, member] : value.members) add(key), add(member);
  }
  void add(const std::vector<FieldMap::Item>& items) {
    add(items.size());
    for (const auto& item : items) {
      add(item.index);
      add(static_cast<int>(item.conversion));
      add(item.required);
      add(item.declared);
    }
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

Bytes of_component(const CompositionPlan& plan, const Component& component) {
  Bytes bytes;
  bytes.add(component.at.pointer());  // which its random numbers are keyed by
  bytes.add(component.type->full_name());
  for (const auto& plugin : plan.catalog.plugins())
    if (plugin.name == component.type->plugin) bytes.add(plugin.version), bytes.add(plugin.file.string());
  bytes.add(component.parameters);
  return bytes;
}

/// Of what emits the channel.
std::string identity_behind(const CompositionPlan& plan, const ChannelPlan& channel) {
  std::string found;
  const auto look = [&](const auto& stages) {
    for (const auto& stage : stages)
      if (stage.pointer == channel.pointer) found = stage.identity;
  };
  look(plan.sources);
  look(plan.transforms);
  return found;
}

}  // namespace

std::string identity_of(const CompositionPlan& plan, const Component& component, const SourcePlan& source) {
  if (source.object->declaration().live) return {};
  Bytes bytes = of_component(plan, component);
  bytes.add(source.latency.has_value());
  if (source.latency) {
    bytes.add(static_cast<int>(source.latency->kind));
    bytes.add(source.latency->first);
    bytes.add(source.latency->second);
    bytes.add(source.latency->fields.size());
    for (const int field : source.latency->fields) bytes.add(field);
  }
  return bytes.take();
}

std::string identity_of(const CompositionPlan& plan, const Component& component, const TransformPlan& transform) {
  Bytes bytes = of_component(plan, component);
  for (const auto& input : transform.inputs) {
    bytes.add(input.channel >= 0);
    if (input.channel < 0) continue;
    const ChannelPlan& channel = plan.channels[as_size(input.channel)];
    const std::string behind = identity_behind(plan, channel);
    if (behind.empty()) return {};
    bytes.add(channel.name);
    bytes.add(behind);
    bytes.add(input.fields.epoch);
    bytes.add(input.fields.row);
  }
  return bytes.take();
}

}  // namespace binnacle::internal::compose
