// SPDX-License-Identifier: Apache-2.0
#include "motion_fields.hpp"

#include <algorithm>

#include "binnacle/catalog.hpp"
#include "binnacle/composition.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

constexpr std::array<const char*, 3> geodetic_units{"rad", "rad", "m"}, velocity_units{"m/s", "m/s", "m/s"};

/// The names of the outputs of the filter's block that has three of these units; none: empty.
std::vector<std::string> outputs_in(const FilterInfo& filter, const std::array<const char*, 3>& units,
                                    std::string_view error_unit) {
  for (const auto& block : filter.blocks) {
    const auto& declaration = *block.declaration;
    const bool are_three = declaration.outputs.size() == 3 && declaration.dof() == 3;
    if (!are_three || declaration.error[0].unit != error_unit) continue;
    bool is_alike = true;
    for (std::size_t i = 0; i < 3; ++i) is_alike = is_alike && declaration.outputs[i].unit == units[i];
    if (is_alike) return names_of(declaration.outputs);
  }
  return {};
}

/// A model's fields with these names, as its channel has them. `at`: the model's place in the config.
std::optional<VectorFields> bound(const std::vector<std::string>& wanted, const ComponentSpec& spec,
                                  const ChannelInfo& channel, const Reader& at) {
  if (wanted.size() != 3) return std::nullopt;
  const auto declared = names_of(spec.fields);
  const auto& fields = channel.declaration->fields;
  VectorFields found;
  for (std::size_t i = 0; i < 3; ++i) {
    if (index_of(declared, wanted[i]) < 0) return std::nullopt;
    const Reader mapped = at["fields"][wanted[i]];
    found.name[i] = mapped ? mapped.text().value_or("") : wanted[i];
    const int its = index_of(names_of(fields), found.name[i]);
    if (its < 0 || fields[as_size(its)].is_per_row) return std::nullopt;
    found.index[i] = channel.position[as_size(its)];
    found.is_rate = fields[as_size(its)].kind == FieldKind::rate;
  }
  return found;
}

/// The first three fields of the model that are integrals, or rates, of this unit.
std::vector<std::string> inertial_names(const ComponentSpec& spec, std::string_view integral, std::string_view rate) {
  std::vector<std::string> names;
  for (const auto& field : spec.fields)
    if (names.size() < 3 && ((field.kind == FieldKind::increment && field.unit == integral) ||
                             (field.kind == FieldKind::rate && field.unit == rate)))
      names.push_back(field.name);
  return names;
}

std::string pointer_of(const FilterInfo& filter) {
  std::string escaped;
  for (const char c : filter.name) escaped += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return "/filters/" + escaped;
}

std::optional<InertialFields> inertial_input(const FilterInfo& filter, CompositionDraft& draft) {
  if (filter.input_channel < 0) return std::nullopt;
  const ChannelInfo& channel = draft.channels()[as_size(filter.input_channel)];
  for (const auto& process : filter.processes) {
    if (!process.type) continue;
    const Reader at = draft.at(pointer_of(filter))["process"][process.name];
    const auto turn = bound(inertial_names(process.type->spec, "rad", "rad/s"), process.type->spec, channel, at);
    const auto force = bound(inertial_names(process.type->spec, "m/s", "m/s^2"), process.type->spec, channel, at);
    if (!turn || !force) continue;
    draft.subscribe(filter.input_channel, at.pointer());
    return InertialFields{filter.input_channel, channel.name, *turn, *force};
  }
  return std::nullopt;
}

/// A model that sees no sample and holds a velocity, in rows of m/s, to axes of the vehicle.
bool holds_to_axis(const MeasurementInfo& info) {
  const auto is_constraint = [](const BoundInfo<MeasurementModel>& part) {
    if (!part.type || !part.type->spec.fields.empty() || !part.type->spec.inputs.empty()) return false;
    const auto& ports = part.type->spec.ports;
    std::vector<std::string> bound;
    for (std::size_t i = 0; i < ports.size() && i < part.ports.size(); ++i)
      if (part.ports[i] >= 0) bound.push_back(ports[i].name);
    return bound.size() == 2 && index_of(bound, "velocity") >= 0 && index_of(bound, "attitude") >= 0;
  };
  return info.parts.size() == 1 && is_constraint(info.parts[0]) && !info.groups.empty() && info.groups[0].unit == "m/s";
}

std::optional<FixFields> fix(const FilterInfo& filter, const MeasurementInfo& info, const Reader& at,
                             const std::vector<ChannelInfo>& channels) {
  const auto position_names = outputs_in(filter, geodetic_units, "m");
  const auto velocity_names = outputs_in(filter, velocity_units, "m/s");
  if (position_names.empty() || info.channel < 0) return std::nullopt;  // its velocity may be along other axes
  const ChannelInfo& channel = channels[as_size(info.channel)];
  std::optional<VectorFields> position, velocity;
  for (const auto& part : info.parts) {
    if (!part.type) continue;
    const Reader part_at = at["stack"] ? at["stack"][part.name] : at;
    if (!position) position = bound(position_names, part.type->spec, channel, part_at);
    if (!velocity) velocity = bound(velocity_names, part.type->spec, channel, part_at);
  }
  if (!velocity) return std::nullopt;
  return FixFields{info.channel, channel.name, info.name, at.pointer(), at.key_origin(), *velocity, position};
}

}  // namespace

std::vector<MotionFields> read_motion_fields(CompositionDraft& draft) {
  std::vector<MotionFields> all;
  if (draft.has_errors()) return all;
  for (std::size_t f = 0; f < draft.filters().size(); ++f) {
    const FilterInfo& filter = draft.filters()[f];
    MotionFields found;
    found.filter = static_cast<int>(f);
    const Reader measurements = draft.at(pointer_of(filter))["measurements"];
    for (const auto& measurement : filter.measurements)
      if (auto fields = fix(filter, measurement, measurements[measurement.name], draft.channels()))
        found.fixes.push_back(std::move(*fields));
    if (found.fixes.empty()) continue;
    for (const auto& its : found.fixes) draft.subscribe(its.channel, its.pointer);
    found.input = inertial_input(filter, draft);
    for (const auto& measurement : filter.measurements)
      if (found.input && holds_to_axis(measurement)) found.input->rolls = measurement.name;
    all.push_back(std::move(found));
  }
  return all;
}

}  // namespace binnacle::score
