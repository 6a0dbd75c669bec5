// SPDX-License-Identifier: Apache-2.0
// What a composition is, for people and programs: `binnacle explain` and `binnacle graph` print this.
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "binnacle/catalog.hpp"
#include "binnacle/composition.hpp"
#include "binnacle/config.hpp"
#include "binnacle/section.hpp"
#include "document/document.hpp"
#include "kind_name.hpp"

namespace binnacle::document {

namespace {

using Json = nlohmann::ordered_json;

/// Only where it is not by hand.
void add_jacobians(Differentiation how, Json& entry) {
  if (how == Differentiation::dual_numbers) entry["jacobians"] = "dual numbers";
  if (how == Differentiation::differences) entry["jacobians"] = "differences";
}

class FilterText {
 public:
  FilterText(const Composition& composition, std::size_t index)
      : composition_(composition), filter_(composition.filters()[index]), index_(static_cast<int>(index)) {}

  Json explanation() const {
    Json text{{"name", filter_.name},
              {"dof", filter_.dof},
              {"covariance", filter_.covariance},
              {"blocks", blocks()},
              {"derived", derived()}};
    text["process"] = processes();
    // A direction without variance has no points.
    if (filter_.is_unscented) text["propagation"] = {{"type", "unscented"}, {"most_sigma_points", 1 + 2 * filter_.dof}};
    text["couplings"] = couplings();
    text["transition"] = transition();
    text["noise"] = pattern(filter_.noise, "row", "column");
    text["measurements"] = measurements();
    for (const auto& section : composition_.sections())
      if (const std::string added = section ? section->explain(index_) : ""; !added.empty())
        text.update(Json::parse(added));
    if (filter_.history > 0)
      text["history"] = {{"length_s", seconds(filter_.history)},
                         {"settled", filter_.name + ".settled"},
                         {"snapshot_bytes", filter_.history_bytes}};
    if (filter_.history_steps > 0) text["history"]["steps"] = filter_.history_steps;
    text["starts_when"] = Json::array();
    for (const auto& initial : filter_.starts_when) {
      Json entry{{"channel", channel(initial.channel)}};
      if (initial.max_age > 0) entry["max_age_s"] = seconds(initial.max_age);
      text["starts_when"].push_back(std::move(entry));
    }
    return text;
  }

 private:
  const std::string& channel(int index) const { return composition_.channels()[static_cast<std::size_t>(index)].name; }
  const std::string& block(int index) const { return filter_.blocks[static_cast<std::size_t>(index)].name; }

  Json blocks() const {
    std::map<std::string, std::string> advanced_by;
    for (const auto& process : filter_.processes)
      for (std::size_t p = 0; p < process.ports.size(); ++p)
        if (process.type->spec.ports[p].access == PortAccess::advances)
          advanced_by[value_name(process.ports[p])] = process.name;
    Json blocks = Json::array();
    for (const auto& block : filter_.blocks) {
      Json components = Json::array();
      int row = block.first_row;
      for (std::size_t i = 0; i < block.use.size(); ++i) {
        const auto& component = block.declaration->error[i];
        Json entry{{"name", component.name}, {"unit", component.unit}, {"use", block.use[i]}};
        if (block.use[i] != "frozen") entry["row"] = row++;
        components.push_back(std::move(entry));
      }
      blocks.push_back({{"name", block.name},
                        {"type", block.type},
                        {"kind", block.declaration->kind},
                        {"advanced_by", advanced_by[block.name]},
                        {"stored", {{"offset", block.stored_offset}, {"size", block.declaration->stored_size}}},
                        {"components", std::move(components)}});
    }
    return blocks;
  }

  /// Of a block or derived block; "" for an open port.
  std::string value_name(int value) const {
    if (value < 0) return "";
    const auto index = static_cast<std::size_t>(value), blocks = filter_.blocks.size();
    return index < blocks ? filter_.blocks[index].name : filter_.derived[index - blocks].name;
  }
  Json names_of(const std::vector<int>& ports) const {
    Json names = Json::array();
    for (const int value : ports)
      if (value >= 0) names.push_back(value_name(value));
    return names;
  }

  /// Blocks, by index, that what a component reads depends on, also through derived values.
  std::set<int> blocks_of(const auto& bound) const {
    std::set<int> blocks;
    for (const int port : bound.object->declaration().read_ports) {
      const auto value = static_cast<std::size_t>(bound.ports[static_cast<std::size_t>(port)]);
      if (value < filter_.blocks.size())
        blocks.insert(static_cast<int>(value));
      else
        blocks.merge(blocks_of(filter_.derived[value - filter_.blocks.size()]));
    }
    return blocks;
  }

  Json derived() const {
    Json derived = Json::array();
    for (const auto& value : filter_.derived) {
      Json depends = Json::array();
      for (const int b : blocks_of(value)) depends.push_back(block(b));
      derived.push_back({{"name", value.name},
                         {"type", value.type->full_name()},
                         {"kind", value.object->declaration().kind},
                         {"reads", names_of(value.ports)},
                         {"depends_on", std::move(depends)}});
      add_jacobians(value.object->declaration().differentiation, derived.back());
    }
    return derived;
  }

  Json processes() const {
    Json processes = Json::array();
    for (const auto& process : filter_.processes) {
      Json advances = Json::array(), reads = Json::array();
      for (std::size_t p = 0; p < process.ports.size(); ++p) {
        if (process.ports[p] < 0) continue;
        const bool is_advanced = process.type->spec.ports[p].access == PortAccess::advances;
        (is_advanced ? advances : reads).push_back(value_name(process.ports[p]));
      }
      Json entry{{"name", process.name}, {"type", process.type->full_name()}, {"advances", advances}, {"reads", reads}};
      if (!process.type->spec.fields.empty()) entry["input"] = channel(filter_.input_channel);
      if (process.discretized_with >= 0) entry["discretized_with_group"] = process.discretized_with;
      add_jacobians(process.object->declaration().differentiation, entry);
      processes.push_back(std::move(entry));
    }
    return processes;
  }

  Json pattern(const std::vector<Coupling>& couplings, const char* row, const char* column) const {
    Json list = Json::array();
    for (const auto& coupling : couplings)
      list.push_back({{row, block(coupling.to)},
                      {column, block(coupling.from)},
                      {"structure", coupling.structure == Structure::diagonal ? "diagonal" : "dense"}});
    return list;
  }

  /// Which block's error is moved by which other's.
  Json couplings() const {
    Json list = Json::array();
    for (const auto& coupling : filter_.transition)
      if (coupling.to != coupling.from) list.push_back({{"to", block(coupling.to)}, {"from", block(coupling.from)}});
    return list;
  }

  /// Φ; blocks that nothing moves are an identity.
  Json transition() const {
    Json list = pattern(filter_.transition, "to", "from");
    std::set<int> moved;
    for (const auto& coupling : filter_.transition) moved.insert(coupling.to);
    for (std::size_t b = 0; b < filter_.blocks.size(); ++b)
      if (const auto& info = filter_.blocks[b]; !info.active.empty() && !moved.contains(static_cast<int>(b)))
        list.push_back({{"to", info.name}, {"from", info.name}, {"structure", "identity"}});
    return list;
  }

  Json part_of(const BoundInfo<MeasurementModel>& part) const {
    Json columns = Json::array();
    for (const int b : blocks_of(part))
      if (!filter_.blocks[static_cast<std::size_t>(b)].active.empty()) columns.push_back(block(b));
    Json entry{{"name", part.name},
               {"type", part.type->full_name()},
               {"reads", names_of(part.ports)},
               {"columns", std::move(columns)}};
    add_jacobians(part.object->declaration().differentiation, entry);
    return entry;
  }

  Json measurements() const {
    Json measurements = Json::array();
    for (const auto& measurement : filter_.measurements) {
      Json parts = Json::array();
      for (const auto& part : measurement.parts) parts.push_back(part_of(part));
      Json entry{{"name", measurement.name},
                 {"channel", channel(measurement.channel)},
                 {"max_rows", measurement.max_rows},
                 {"parts", std::move(parts)}};
      if (const auto& gate = measurement.gate; gate.probability > 0)
        entry["gate"] = {{"probability", gate.probability},
                         {"by", gate.by},
                         {"nis_limit", gate.nis_limit},
                         {"recovers", measurement.recovers}};
      if (const auto& update = measurement.update; update.type != "ekf") {
        entry["update"] = {{"type", update.type}};
        if (update.max > 0) entry["update"].update({{"max", update.max}, {"tolerance", update.tolerance}});
      }
      if (measurement.noise.type) entry["noise"] = measurement.noise.type->full_name();
      measurements.push_back(std::move(entry));
    }
    return measurements;
  }

  const Composition& composition_;
  const FilterInfo& filter_;
  int index_;
};

Json channels_of(const Composition& composition) {
  Json channels = Json::array();
  for (const auto& channel : composition.channels()) {
    Json fields = Json::array();
    for (const auto& field : channel.declaration->fields)
      fields.push_back(
          {{"name", field.name}, {"unit", field.unit}, {"kind", kind_name(field.kind)}, {"per_row", field.is_per_row}});
    channels.push_back({{"name", channel.name},
                        {"from", channel.pointer},
                        {"fields", std::move(fields)},
                        {"subscribers", channel.subscribers}});
  }
  return channels;
}

/// A filter's own channel may go unused.
Json unused_channels(const Composition& composition) {
  std::set<std::string> of_filters;
  for (const auto& filter : composition.filters()) of_filters.insert(join_pointer("/filters", filter.name));
  Json unused = Json::array();
  for (const auto& channel : composition.channels())
    if (channel.subscribers.empty() && !of_filters.contains(channel.pointer)) unused.push_back(channel.name);
  return unused;
}

Json stages(const Composition& composition, const auto& infos, bool has_inputs) {
  const auto names = [&](const std::vector<int>& channels) {
    Json list = Json::array();
    for (const int c : channels) list.push_back(composition.channels()[static_cast<std::size_t>(c)].name);
    return list;
  };
  Json stages = Json::array();
  for (const auto& info : infos) {
    Json stage{{"name", info.name}, {"type", info.type->full_name()}};
    if (has_inputs) stage["inputs"] = names(info.inputs);
    stage["outputs"] = names(info.outputs);
    stages.push_back(std::move(stage));
  }
  return stages;
}

Json found_by_components(const Composition& composition) {
  Json found = Json::array();
  for (const auto& component : composition.found()) {
    Json figures = Json::array();
    for (const auto& figure : component.figures)
      figures.push_back({{"name", figure.name}, {"value", figure.value}, {"unit", figure.unit}});
    found.push_back({{"at", component.pointer}, {"figures", std::move(figures)}});
  }
  return found;
}

}  // namespace

Json explain(const Composition& composition) {
  Json filters = Json::array();
  for (std::size_t f = 0; f < composition.filters().size(); ++f)
    filters.push_back(FilterText(composition, f).explanation());
  return {{"title", composition.title()},
          {"sources", stages(composition, composition.sources(), false)},
          {"transforms", stages(composition, composition.transforms(), true)},
          {"channels", channels_of(composition)},
          {"filters", std::move(filters)},
          {"unused_channels", unused_channels(composition)},
          {"found", found_by_components(composition)},
          {"arena_bytes", composition.arena_bytes()}};
}

}  // namespace binnacle::document
