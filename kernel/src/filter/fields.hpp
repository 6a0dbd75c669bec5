// SPDX-License-Identifier: Apache-2.0
// How components read a channel's samples, and how the latest sample of a channel is kept.
#pragma once

#include <cstddef>

#include "binnacle/sample.hpp"
#include "filter/plan.hpp"

namespace binnacle::filter {

/// Per-epoch fields of a channel as a component declared them, converted. dt: length that they belong to.
void convert(const FieldMap& map, const double* fields, double dt, double* converted);
/// A channel's sample as a component declared its fields; `numbers`, of FieldMap::doubles(), hold them.
SampleView convert(const FieldMap& map, const ChannelPlan& channel, const SampleView& sample, double* numbers);
/// Whether every required per-epoch field is a number.
bool is_complete(const FieldMap& map, const SampleView& sample);

inline double interval_of(const SampleView& sample) {
  return sample.t0 == no_time ? 0.0 : seconds(sample.t - sample.t0);
}

/// A sample's numbers to `data`, of ChannelPlan::doubles(), and what else there is of it; and back.
SampleHead pack(const ChannelPlan& channel, const SampleView& sample, double* data);
SampleView unpack(const ChannelPlan& channel, const SampleHead& head, const double* data);

/// Not available before the first one.
inline SampleView latest(const LatestPlan& plan, const ChannelPlan& channel, const std::byte* arena) {
  return unpack(channel, *plan.head.in(arena), plan.data.in(arena));
}

}  // namespace binnacle::filter
