// SPDX-License-Identifier: Apache-2.0
#include "filter/fields.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace binnacle::filter {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

}  // namespace

int read_fields(const FieldMap& map, const SampleView& sample, double dt, double* epoch) {
  int missing = -1;
  for (const auto& item : map.epoch) {
    double value = item.index < 0 ? not_a_number : sample.fields[item.index];
    if (item.required && !std::isfinite(value) && missing < 0) missing = item.declared;
    if (item.conversion == FieldMap::Conversion::to_rate) value /= dt;
    if (item.conversion == FieldMap::Conversion::to_increment) value *= dt;
    *epoch++ = value;
  }
  return missing;
}

void read_row_fields(const FieldMap& map, const ChannelPlan& channel, const SampleView& sample, double* rows) {
  for (int row = 0; row < sample.rows; ++row)
    for (const auto& item : map.row)
      *rows++ = item.index < 0 ? not_a_number : sample.row_fields[row * channel.row_fields + item.index];
}

void pack(const ChannelPlan& channel, const SampleView& sample, double* data) {
  data = std::copy_n(sample.fields, channel.epoch_fields, data);
  if (channel.row_fields > 0) std::copy_n(sample.row_fields, channel.row_fields * sample.rows, data);
  data += channel.row_fields * channel.declaration.max_rows;
  if (sample.covariance) std::copy_n(sample.covariance, channel.covariance_dof * channel.covariance_dof, data);
}

SampleView unpack(const ChannelPlan& channel, const double* data, Time t, Time t0, int rows, bool has_covariance) {
  const double* row_fields = data + channel.epoch_fields;
  const double* covariance = row_fields + channel.row_fields * channel.declaration.max_rows;
  return {t, t0, rows, data, row_fields, has_covariance ? covariance : nullptr, true};
}

void forget_latest(const LatestPlan& plan, std::byte* arena) {
  std::fill_n(plan.data.in(arena), plan.data.count, not_a_number);
  std::fill_n(plan.times.in(arena), 2, no_time);
  std::fill_n(plan.state.in(arena), 3, 0);
}

void keep_latest(const LatestPlan& plan, const ChannelPlan& channel, const SampleView& sample, std::byte* arena) {
  pack(channel, sample, plan.data.in(arena));
  plan.times.in(arena)[0] = sample.t;
  plan.times.in(arena)[1] = sample.t0;
  std::int32_t* state = plan.state.in(arena);
  state[0] = sample.rows;
  state[1] = sample.covariance != nullptr;
  state[2] = 1;
}

SampleView latest(const LatestPlan& plan, const ChannelPlan& channel, const std::byte* arena) {
  const Time* times = plan.times.in(arena);
  const std::int32_t* state = plan.state.in(arena);
  SampleView view = unpack(channel, plan.data.in(arena), times[0], times[1], state[0], state[1] != 0);
  view.available = state[2] != 0;
  return view;
}

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
