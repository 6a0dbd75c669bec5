// SPDX-License-Identifier: Apache-2.0
// When a simulator's channels emit.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "binnacle/time.hpp"

namespace binnacle::simulation {

inline constexpr Time never = std::numeric_limits<Time>::max();

/// Instants at a constant rate, to the nearest nanosecond, counted from zero.
class Clock {
 public:
  explicit Clock(double rate) : rate_(rate) {}
  Time at(std::int64_t tick) const { return std::llround(static_cast<double>(tick) * 1e9 / rate_); }
  /// The same, or never: for a rate of zero, beyond `end`, and for what no run counts but a damaged memory may.
  Time due(std::int64_t tick, Time end) const {
    constexpr double beyond_all_times = 0x1p63;
    if (rate_ <= 0.0 || tick < 0 || static_cast<double>(tick) * 1e9 / rate_ >= beyond_all_times) return never;
    return at(tick) <= end ? at(tick) : never;
  }
  double interval_before(std::int64_t tick) const { return seconds(at(tick) - at(tick - 1)); }

 private:
  double rate_;  // Hz; 0: never
};

}  // namespace binnacle::simulation
