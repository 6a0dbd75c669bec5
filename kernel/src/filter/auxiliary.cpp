// SPDX-License-Identifier: Apache-2.0
#include "filter/auxiliary.hpp"

#include <algorithm>

#include "filter/fields.hpp"

namespace binnacle::filter {

AuxiliaryReader::AuxiliaryReader(const FilterPlan& plan, const std::vector<ChannelPlan>& channels,
                                 const std::byte* arena)
    : plan_(plan), channels_(channels), arena_(arena) {
  std::size_t count = 0, doubles = 0;
  const auto widen = [&](const AuxiliaryPlan& model) {
    count = std::max(count, model.channels.size());
    std::size_t sum = 0;
    for (std::size_t i = 0; i < model.channels.size(); ++i) {
      const int index = model.channels[i];
      const int rows = index < 0 ? 0 : channels[as_size(plan.auxiliary[as_size(index)].channel)].declaration.max_rows;
      sum += model.fields[i].epoch.size() + model.fields[i].row.size() * as_size(rows);
    }
    doubles = std::max(doubles, sum);
  };
  for (const auto& process : plan.processes) widen(process.auxiliary);
  for (const auto& measurement : plan.measurements)
    for (const auto& part : measurement.parts) widen(part.auxiliary);
  samples_.resize(count);
  fields_.resize(doubles);
}

const SampleView* AuxiliaryReader::read_all(const AuxiliaryPlan& model) {
  double* fields = fields_.data();
  for (std::size_t i = 0; i < model.channels.size(); ++i) {
    SampleView& view = samples_[i];
    view = SampleView{};
    if (model.channels[i] < 0) continue;
    const auto& kept = plan_.auxiliary[as_size(model.channels[i])];
    const auto& channel = channels_[as_size(kept.channel)];
    const SampleView raw = latest(kept, channel, arena_);
    view = raw;
    view.fields = fields;
    read_fields(model.fields[i], raw, interval_of(raw), fields);
    fields += model.fields[i].epoch.size();
    view.row_fields = fields;
    read_row_fields(model.fields[i], channel, raw, fields);
    fields += model.fields[i].row.size() * as_size(raw.rows);
  }
  return samples_.data();
}

}  // namespace binnacle::filter
