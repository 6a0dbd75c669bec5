// SPDX-License-Identifier: Apache-2.0
// What a Composition shows of itself: filters, channels, and who feeds whom.
#include <algorithm>
#include <map>

#include "compose/composer.hpp"

namespace binnacle::compose {

namespace {

BlockInfo block_info(const BlockPlan& block) {
  BlockInfo info{block.name,          block.type,  block.block.get(), &block.declaration(),
                 block.stored_offset, block.first, block.active,      {}};
  for (const Use use : block.use)
    info.use.push_back(use == Use::estimated ? "estimated" : use == Use::considered ? "considered" : "frozen");
  return info;
}

/// The block itself, or for a derived value the block of the filter with the same error components; −1: none.
int block_like(const FilterPlan& filter, int value) {
  const auto blocks = filter.blocks.size();
  if (value < 0 || as_size(value) < blocks) return value;
  const auto& kind = filter.derived[as_size(value) - blocks].derived->declaration().kind;
  for (std::size_t b = 0; b < blocks; ++b)
    if (filter.blocks[b].declaration().kind == kind) return static_cast<int>(b);
  return -1;
}

std::vector<RowGroupInfo> row_groups(const FilterPlan& filter, const MeasurementPlan& measurement) {
  std::vector<RowGroupInfo> all;
  for (const auto& part : measurement.parts) {
    const auto& groups = part.model->declaration().groups;
    if (groups.empty()) all.push_back({part.name, "", "", -1});
    for (const auto& group : groups) {
      const std::string name = groups.size() < 2              ? part.name
                               : measurement.parts.size() > 1 ? part.name + "." + group.name
                                                              : group.name;
      const int like = group.port < 0 ? -1 : block_like(filter, part.ports[as_size(group.port)]);
      const auto& unit = like < 0 ? group.unit : filter.blocks[as_size(like)].declaration().error.front().unit;
      all.push_back({name, unit, group.name, like});
    }
  }
  return all;
}

MeasurementInfo measurement_info(const FilterPlan& filter, const MeasurementPlan& measurement) {
  MeasurementInfo info;
  info.name = measurement.name;
  info.channel = measurement.channel;
  info.max_rows = measurement.max_rows;
  for (const auto& part : measurement.parts) info.parts.push_back(part.name);
  info.groups = row_groups(filter, measurement);
  const auto& columns = measurement.columns;
  for (std::size_t b = 0; b < filter.blocks.size(); ++b)
    if (!filter.blocks[b].active.empty() &&
        std::find(columns.begin(), columns.end(), filter.blocks[b].first) != columns.end())
      info.blocks.push_back(static_cast<int>(b));
  info.adapts_noise = measurement.noise != nullptr;
  info.recovers = measurement.recover_after > 0;
  static constexpr const char* units[] = {"sample", "row", "key"};
  if (measurement.gate > 0)
    info.gate = {measurement.gate, units[static_cast<int>(measurement.gate_unit)],
                 measurement.gate_limit[measurement.gate_unit == GateUnit::row ? 1 : as_size(info.max_rows)]};
  return info;
}

/// Blocks of a matrix over P's rows that are declared other than zero.
class Pattern {
 public:
  explicit Pattern(const FilterPlan& filter) : filter_(filter) {}

  void add(int row, int column) {
    const auto [to, to_component] = place_of(row);
    const auto [from, from_component] = place_of(column);
    auto& is_diagonal = blocks_.try_emplace({to, from}, true).first->second;
    is_diagonal = is_diagonal && to_component == from_component;
  }
  std::vector<BlockCoupling> couplings() const {
    std::vector<BlockCoupling> list;
    for (const auto& [key, is_diagonal] : blocks_)
      list.push_back({key.first, key.second, is_diagonal ? Structure::diagonal : Structure::dense});
    return list;
  }

 private:
  /// The block that a row of P is of, and which of its rows.
  std::pair<int, int> place_of(int row) const {
    int b = 0;
    while (row >= filter_.blocks[as_size(b)].first + static_cast<int>(filter_.blocks[as_size(b)].active.size())) ++b;
    return {b, row - filter_.blocks[as_size(b)].first};
  }

  const FilterPlan& filter_;
  std::map<std::pair<int, int>, bool> blocks_;
};

std::vector<BlockCoupling> transition_pattern(const FilterPlan& filter) {
  Pattern pattern(filter);
  for (const auto& group : filter.transition.groups)
    for (int r = 0; r < group.rows; ++r)
      for (const auto& column : group.columns) pattern.add(group.first_row + r, column.column);
  for (const auto& diagonal : filter.transition.diagonals) pattern.add(diagonal.row, diagonal.row);
  return pattern.couplings();
}

/// Of Qd, of which models declare one half.
std::vector<BlockCoupling> noise_pattern(const FilterPlan& filter) {
  Pattern pattern(filter);
  for (const auto& noise : filter.transition.noise)
    for (int r = 0; r < noise.rows; ++r)
      for (int c = 0; c < noise.columns; ++c) {
        if (noise.stride == 0 && r != c) continue;
        pattern.add(noise.row + r, noise.column + c);
        pattern.add(noise.column + c, noise.row + r);
      }
  return pattern.couplings();
}

}  // namespace

std::vector<FilterInfo> filter_infos(const CompositionPlan& plan) {
  std::vector<FilterInfo> infos;
  for (const auto& filter : plan.filters) {
    FilterInfo& info = infos.emplace_back();
    info.name = filter.name;
    info.dof = filter.n;
    info.stored_size = filter.stored_size;
    info.input_channel = filter.input_channel;
    for (const auto& block : filter.blocks) info.blocks.push_back(block_info(block));
    for (const auto& value : filter.derived) info.derived.push_back(value.name);
    for (const auto& process : filter.processes) info.processes.push_back({process.name, process.van_loan_group});
    for (const auto& measurement : filter.measurements)
      info.measurements.push_back(measurement_info(filter, measurement));
    for (const auto& initial : filter.initial) info.starts_when.push_back({initial.channel, initial.max_age});
    info.transition = transition_pattern(filter);
    info.noise = noise_pattern(filter);
  }
  return infos;
}

std::vector<ChannelInfo> channel_infos(const CompositionPlan& plan) {
  std::vector<ChannelInfo> infos;
  for (std::size_t c = 0; c < plan.channels.size(); ++c) {
    const auto& channel = plan.channels[c];
    infos.push_back({channel.name, &channel.declaration, channel.position, channel.pointer, {}});
    if (!plan.subscribers.empty()) infos.back().subscribers = plan.subscribers[c];
  }
  return infos;
}

std::vector<std::vector<std::string>> subscribers(const CompositionPlan& plan) {
  std::vector<std::vector<std::string>> by_channel(plan.channels.size());
  const auto add = [&](int channel, const std::string& pointer) {
    if (channel < 0) return;
    auto& list = by_channel[as_size(channel)];
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
  return by_channel;
}

}  // namespace binnacle::compose
