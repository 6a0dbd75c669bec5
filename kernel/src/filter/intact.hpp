// SPDX-License-Identifier: Apache-2.0
// Whether memory that came from outside, of a snapshot or a checkpoint, is what a filter may go on with: its counts, indices
// and times are in range, whatever its checksum says. Numbers of the state are judged by the health check.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/time_range.hpp"
#include "filter/monitor.hpp"
#include "filter/plan.hpp"

namespace binnacle::internal::filter {

/// No sum of thousands of counts below it overflows.
inline constexpr std::int64_t beyond_count = std::int64_t{1} << 48;

inline bool is_count(std::int64_t count) { return count >= 0 && count < beyond_count; }
inline bool is_length(Time length) { return length >= 0 && base::is_near(length); }
inline bool is_time(Time t) { return t == no_time || base::is_near(t); }

/// Of a sample as it is kept on the channel.
bool is_intact(const SampleHead& head, const ChannelPlan& channel);
/// Of a filter in this arena.
bool is_intact(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, const std::byte* arena);

}  // namespace binnacle::internal::filter
