// SPDX-License-Identifier: Apache-2.0
// What a composition is, told for people: `binnacle explain` and `binnacle graph` print this.
#include <algorithm>
#include <map>
#include <set>

#include "base/index.hpp"
#include "binnacle/composition.hpp"
#include "compose/composer.hpp"

namespace binnacle::compose {

namespace {

using Json = nlohmann::ordered_json;

using base::as_size;

const char* kind_name(FieldKind kind) {
  return kind == FieldKind::rate ? "rate" : kind == FieldKind::increment ? "increment" : "level";
}

std::string value_name(const FilterPlan& filter, int value) {
  if (value < 0) return "";
  const auto blocks = filter.blocks.size();
  return as_size(value) < blocks ? filter.blocks[as_size(value)].name : filter.derived[as_size(value) - blocks].name;
}

Json explain_blocks(const FilterPlan& filter) {
  Json blocks = Json::array();
  for (const auto& block : filter.blocks) {
    Json components = Json::array();
    int row = block.first;
    for (std::size_t i = 0; i < block.use.size(); ++i) {
      const auto& component = block.declaration().error[i];
      const Use use = block.use[i];
      Json entry{{"name", component.name},
                 {"unit", component.unit},
                 {"use", use == Use::estimated    ? "estimated"
                         : use == Use::considered ? "considered"
                                                  : "frozen"}};
      if (use != Use::frozen) entry["row"] = row++;
      components.push_back(std::move(entry));
    }
    blocks.push_back({{"name", block.name},
                      {"type", block.type},
                      {"kind", block.declaration().kind},
                      {"advanced_by", block.process < 0 ? "" : filter.processes[as_size(block.process)].name},
                      {"stored", {{"offset", block.stored_offset}, {"size", block.declaration().stored_size}}},
                      {"components", std::move(components)}});
  }
  return blocks;
}

/// Which rows of which block of Φ depend on which other block: the couplings as the covariance sees them.
Json explain_transition(const FilterPlan& filter) {
  const auto block_of = [&](int row) {
    for (const auto& block : filter.blocks)
      if (row >= block.first && row < block.first + static_cast<int>(block.active.size())) return block.name;
    return std::string();
  };
  Json couplings = Json::array();
  std::set<std::pair<std::string, std::string>> seen;
  for (const auto& group : filter.transition.groups)
    for (const auto& column : group.columns) {
      const auto pair = std::make_pair(block_of(group.first_row), block_of(column.column));
      if (pair.first != pair.second && seen.insert(pair).second)
        couplings.push_back({{"to", pair.first}, {"from", pair.second}});
    }
  return couplings;
}

/// The block and its component that a row of P is of.
struct Place {
  std::size_t block = 0;
  int component = 0;
};

Place place_of(const FilterPlan& filter, int row) {
  for (std::size_t b = 0; b < filter.blocks.size(); ++b) {
    const auto& block = filter.blocks[b];
    if (row >= block.first && row < block.first + static_cast<int>(block.active.size())) return {b, row - block.first};
  }
  return {};
}

/// What the blocks of a matrix are declared to be, by (row, column); what is not in it is zero.
class BlockPattern {
 public:
  void add(Place row, Place column) {
    auto& is_diagonal = blocks_.try_emplace({row.block, column.block}, true).first->second;
    is_diagonal = is_diagonal && row.component == column.component;
  }
  bool has_row(std::size_t block) const {
    return std::any_of(blocks_.begin(), blocks_.end(), [&](const auto& entry) { return entry.first.first == block; });
  }
  Json told(const FilterPlan& filter, const char* row, const char* column) const {
    Json list = Json::array();
    for (const auto& [key, is_diagonal] : blocks_)
      list.push_back({{row, filter.blocks[key.first].name},
                      {column, filter.blocks[key.second].name},
                      {"structure", is_diagonal ? "diagonal" : "dense"}});
    return list;
  }

 private:
  std::map<std::pair<std::size_t, std::size_t>, bool> blocks_;
};

/// Φ; blocks that nothing moves are an identity.
Json explain_pattern(const FilterPlan& filter) {
  BlockPattern pattern;
  for (const auto& group : filter.transition.groups)
    for (int r = 0; r < group.rows; ++r)
      for (const auto& column : group.columns)
        pattern.add(place_of(filter, group.first_row + r), place_of(filter, column.column));
  for (const auto& diagonal : filter.transition.diagonals)
    pattern.add(place_of(filter, diagonal.row), place_of(filter, diagonal.row));
  Json list = pattern.told(filter, "to", "from");
  for (std::size_t b = 0; b < filter.blocks.size(); ++b)
    if (!filter.blocks[b].active.empty() && !pattern.has_row(b))
      list.push_back({{"to", filter.blocks[b].name}, {"from", filter.blocks[b].name}, {"structure", "identity"}});
  return list;
}

/// Qd, of which models declare one half.
Json explain_noise(const FilterPlan& filter) {
  BlockPattern pattern;
  for (const auto& noise : filter.transition.noise)
    for (int r = 0; r < noise.rows; ++r)
      for (int c = 0; c < noise.columns; ++c) {
        if (noise.stride == 0 && r != c) continue;
        const Place row = place_of(filter, noise.row + r), column = place_of(filter, noise.column + c);
        pattern.add(row, column);
        pattern.add(column, row);
      }
  return pattern.told(filter, "row", "column");
}

/// Blocks that a part's H has columns of, those behind derived values too.
Json explain_columns(const FilterPlan& filter, const PartPlan& part) {
  std::set<int> seen;
  for (const auto& read : part.reads)
    for (const auto& target : read.targets)
      if (!filter.blocks[as_size(target.block)].active.empty()) seen.insert(target.block);
  Json names = Json::array();
  for (const int block : seen) names.push_back(filter.blocks[as_size(block)].name);
  return names;
}

Json port_names(const FilterPlan& filter, const std::vector<int>& values) {
  Json names = Json::array();
  for (const int value : values)
    if (value >= 0) names.push_back(value_name(filter, value));
  return names;
}

/// Only where it is not by hand.
void explain_jacobians(Differentiation how, Json& entry) {
  if (how == Differentiation::dual_numbers) entry["jacobians"] = "dual numbers";
  if (how == Differentiation::differences) entry["jacobians"] = "differences";
}

Json explain_derived(const FilterPlan& filter) {
  Json derived = Json::array();
  for (const auto& value : filter.derived) {
    Json depends = Json::array();
    for (const auto& dependence : value.dependences) depends.push_back(filter.blocks[as_size(dependence.block)].name);
    derived.push_back({{"name", value.name},
                       {"type", value.type},
                       {"kind", value.derived->declaration().kind},
                       {"reads", port_names(filter, value.ports)},
                       {"depends_on", std::move(depends)}});
    explain_jacobians(value.derived->declaration().differentiation, derived.back());
  }
  return derived;
}

Json explain_processes(const CompositionPlan& plan, const FilterPlan& filter) {
  Json processes = Json::array();
  for (std::size_t p = 0; p < filter.processes.size(); ++p) {
    const auto& process = filter.processes[p];
    Json advances = Json::array(), reads = Json::array();
    for (const int value : process.ports) {
      if (value < 0) continue;
      const bool is_advanced =
          as_size(value) < filter.blocks.size() && filter.blocks[as_size(value)].process == static_cast<int>(p);
      (is_advanced ? advances : reads).push_back(value_name(filter, value));
    }
    Json entry{{"name", process.name}, {"type", process.type}, {"advances", advances}, {"reads", reads}};
    if (process.uses_input) entry["input"] = plan.channels[as_size(filter.input_channel)].name;
    if (process.van_loan_group >= 0) entry["discretized_with_group"] = process.van_loan_group;
    explain_jacobians(process.model->declaration().differentiation, entry);
    processes.push_back(std::move(entry));
  }
  return processes;
}

Json explain_measurements(const CompositionPlan& plan, const FilterPlan& filter) {
  static constexpr const char* gate_units[] = {"sample", "row", "key"};
  Json measurements = Json::array();
  for (const auto& measurement : filter.measurements) {
    Json parts = Json::array();
    for (const auto& part : measurement.parts) {
      parts.push_back({{"name", part.name},
                       {"type", part.type},
                       {"reads", port_names(filter, part.ports)},
                       {"columns", explain_columns(filter, part)}});
      explain_jacobians(part.model->declaration().differentiation, parts.back());
    }
    Json entry{{"name", measurement.name},
               {"channel", plan.channels[as_size(measurement.channel)].name},
               {"max_rows", measurement.max_rows},
               {"parts", std::move(parts)}};
    if (measurement.gate > 0)
      entry["gate"] = {
          {"probability", measurement.gate},
          {"by", gate_units[static_cast<int>(measurement.gate_unit)]},
          {"nis_limit",
           measurement.gate_limit[measurement.gate_unit == GateUnit::row ? 1 : as_size(measurement.max_rows)]}};
    if (!measurement.noise_type.empty()) entry["noise"] = measurement.noise_type;
    measurements.push_back(std::move(entry));
  }
  return measurements;
}

Json explain_filter(const CompositionPlan& plan, std::size_t index) {
  const FilterPlan& filter = plan.filters[index];
  Json explanation{{"name", filter.name}, {"dof", filter.n}, {"blocks", explain_blocks(filter)}};
  explanation["derived"] = explain_derived(filter);
  explanation["process"] = explain_processes(plan, filter);
  explanation["couplings"] = explain_transition(filter);
  explanation["transition"] = explain_pattern(filter);
  explanation["noise"] = explain_noise(filter);
  explanation["measurements"] = explain_measurements(plan, filter);
  for (const auto& section : plan.sections)
    if (const std::string added = section ? section->explain(static_cast<int>(index)) : ""; !added.empty())
      explanation.update(Json::parse(added));
  Json initial = Json::array();
  for (const auto& latest : filter.initial) {
    Json entry{{"channel", plan.channels[as_size(latest.channel)].name}};
    if (latest.max_age > 0) entry["max_age_s"] = seconds(latest.max_age);
    initial.push_back(std::move(entry));
  }
  explanation["starts_when"] = std::move(initial);
  return explanation;
}

bool is_filter_output(const CompositionPlan& plan, std::size_t channel) {
  return std::any_of(plan.filters.begin(), plan.filters.end(),
                     [&](const FilterPlan& filter) { return filter.output_channel == static_cast<int>(channel); });
}

}  // namespace

std::vector<std::vector<std::string>> listeners(const CompositionPlan& plan) {
  std::vector<std::vector<std::string>> heard(plan.channels.size());
  const auto add = [&](int channel, const std::string& pointer) {
    if (channel < 0) return;
    auto& list = heard[as_size(channel)];
    if (std::find(list.begin(), list.end(), pointer) == list.end()) list.push_back(pointer);
  };
  for (const auto& transform : plan.transforms)
    for (const auto& input : transform.inputs) add(input.channel, transform.pointer);
  for (const auto& sink : plan.sinks)
    for (const auto& input : sink.inputs) add(input.channel, sink.pointer);
  for (const auto& filter : plan.filters) {
    const auto add_auxiliary = [&](const auto& model) {
      for (const int index : model.auxiliary.channels)
        if (index >= 0) add(filter.auxiliary[as_size(index)].channel, model.pointer);
    };
    for (const auto& process : filter.processes) {
      if (process.uses_input) add(filter.input_channel, process.pointer);
      add_auxiliary(process);
    }
    for (const auto& measurement : filter.measurements) {
      add(measurement.channel, measurement.pointer);
      for (const auto& part : measurement.parts) add_auxiliary(part);
    }
    for (const auto& block : filter.blocks)
      if (block.initial.channel >= 0)
        add(filter.initial[as_size(block.initial.channel)].channel, block.pointer + "/init");
  }
  for (const auto& subscription : plan.subscriptions) add(subscription.channel, subscription.pointer);
  return heard;
}

Json explain(const CompositionPlan& plan) {
  const auto heard = listeners(plan);
  Json channels = Json::array(), unused = Json::array();
  for (std::size_t c = 0; c < plan.channels.size(); ++c) {
    const auto& channel = plan.channels[c];
    Json fields = Json::array();
    for (const auto& field : channel.declaration.fields)
      fields.push_back(
          {{"name", field.name}, {"unit", field.unit}, {"kind", kind_name(field.kind)}, {"per_row", field.is_per_row}});
    channels.push_back(
        {{"name", channel.name}, {"from", channel.pointer}, {"fields", std::move(fields)}, {"heard_by", heard[c]}});
    if (heard[c].empty() && !is_filter_output(plan, c)) unused.push_back(channel.name);
  }
  Json transforms = Json::array();
  for (const auto& transform : plan.transforms) {
    Json inputs = Json::array(), outputs = Json::array();
    for (const auto& input : transform.inputs)
      if (input.channel >= 0) inputs.push_back(plan.channels[as_size(input.channel)].name);
    for (const int channel : transform.channels) outputs.push_back(plan.channels[as_size(channel)].name);
    transforms.push_back({{"name", transform.name},
                          {"type", transform.type->full_name()},
                          {"inputs", std::move(inputs)},
                          {"outputs", std::move(outputs)}});
  }
  Json sources = Json::array();
  for (const auto& source : plan.sources) {
    Json outputs = Json::array();
    for (const int channel : source.channels) outputs.push_back(plan.channels[as_size(channel)].name);
    sources.push_back({{"name", source.name}, {"type", source.type->full_name()}, {"outputs", std::move(outputs)}});
  }
  Json filters = Json::array();
  for (std::size_t f = 0; f < plan.filters.size(); ++f) filters.push_back(explain_filter(plan, f));
  Json found = Json::array();
  for (const auto& component : plan.found) {
    Json figures = Json::array();
    for (const auto& figure : component.figures)
      figures.push_back({{"name", figure.name}, {"value", figure.value}, {"unit", figure.unit}});
    found.push_back({{"at", component.pointer}, {"figures", std::move(figures)}});
  }
  return {{"title", plan.title},       {"sources", std::move(sources)},    {"transforms", std::move(transforms)},
          {"channels", channels},      {"filters", std::move(filters)},    {"unused_channels", std::move(unused)},
          {"found", std::move(found)}, {"arena_bytes", plan.layout.size()}};
}

}  // namespace binnacle::compose

namespace binnacle {

nlohmann::ordered_json Composition::explain() const { return compose::explain(*plan_); }

}  // namespace binnacle
