// SPDX-License-Identifier: Apache-2.0
// How components read a channel's samples, and how the latest sample of a channel is kept.
#pragma once

#include <cstddef>
#include <vector>

#include "binnacle/sample.hpp"
#include "filter/plan.hpp"

namespace binnacle::filter {

/// Reads a component's fields from a channel's sample, converted. Returns the index into `map.names` of a required
/// per-epoch field that is not finite, or −1.
int read_fields(const FieldMap& map, const SampleView& sample, double dt, double* epoch);
void read_row_fields(const FieldMap& map, const ChannelPlan& channel, const SampleView& sample, double* rows);

inline double interval_of(const SampleView& sample) {
  return sample.t0 == no_time ? 0.0 : seconds(sample.t - sample.t0);
}

/// A sample's numbers in `data`, of ChannelPlan::doubles(), and a view of them.
void pack(const ChannelPlan& channel, const SampleView& sample, double* data);
SampleView unpack(const ChannelPlan& channel, const double* data, Time t, Time t0, int rows, bool has_covariance);

void forget_latest(const LatestPlan& plan, std::byte* arena);
void keep_latest(const LatestPlan& plan, const ChannelPlan& channel, const SampleView& sample, std::byte* arena);
/// Not available before the first one.
SampleView latest(const LatestPlan& plan, const ChannelPlan& channel, const std::byte* arena);

/// The latest samples of a model's auxiliary channels, as it declared their fields.
class AuxiliaryReader {
 public:
  AuxiliaryReader(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, const std::byte* arena);

  /// One per declared input, good until the next call; null for a model without any.
  const SampleView* read(const AuxiliaryPlan& model) { return model.channels.empty() ? nullptr : read_all(model); }

 private:
  const SampleView* read_all(const AuxiliaryPlan& model);

  const FilterPlan& plan_;
  const std::vector<ChannelPlan>& channels_;
  const std::byte* arena_;
  std::vector<SampleView> samples_;
  std::vector<double> fields_;
};

}  // namespace binnacle::filter
