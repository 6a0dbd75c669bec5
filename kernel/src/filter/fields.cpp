// SPDX-License-Identifier: Apache-2.0
// How components read a channel's samples, and how the latest sample of a channel is kept.
#include <algorithm>
#include <limits>

#include "filter/plan.hpp"

namespace binnacle::internal::filter {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

void convert(const FieldMap& map, const double* fields, double dt, double* converted) {
  for (const auto& item : map.epoch) {
    double value = item.index < 0 ? no_number : fields[item.index];
    if (item.conversion != FieldMap::Conversion::none)
      item.conversion == FieldMap::Conversion::to_rate ? value /= dt : value *= dt;
    *converted++ = value;
  }
}

SampleView convert(const FieldMap& map, const ChannelPlan& channel, const SampleView& sample, double* numbers) {
  SampleView view = sample;
  view.fields = numbers;
  convert(map, sample.fields, sample.t0 == no_time ? 0.0 : seconds(sample.t - sample.t0), numbers);
  numbers += map.epoch.size();
  view.row_fields = numbers;
  for (int row = 0; row < sample.rows; ++row)
    for (const auto& item : map.row)
      *numbers++ = item.index < 0 ? no_number : sample.row_fields[row * channel.row_fields + item.index];
  return view;
}

SampleHead pack(const ChannelPlan& channel, const SampleView& sample, double* data) {
  data = std::copy_n(sample.fields, channel.epoch_fields, data);
  if (channel.row_fields > 0) std::copy_n(sample.row_fields, channel.row_fields * sample.rows, data);
  data += channel.row_fields * channel.declaration.max_rows;
  if (sample.covariance) std::copy_n(sample.covariance, channel.covariance_dof * channel.covariance_dof, data);
  return {sample.t, sample.t0, sample.rows, sample.covariance != nullptr};
}

SampleView unpack(const ChannelPlan& channel, const SampleHead& head, const double* data) {
  const double* row_fields = data + channel.epoch_fields;
  const double* covariance = row_fields + channel.row_fields * channel.declaration.max_rows;
  return {head.t, head.t0, head.rows, data, row_fields, head.has_covariance ? covariance : nullptr, head.t != no_time};
}

}  // namespace binnacle::internal::filter
