// SPDX-License-Identifier: Apache-2.0
// When a simulator's channels emit.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include "binnacle/time.hpp"

namespace binnacle::simulation {

inline constexpr Time never = std::numeric_limits<Time>::max();

/// Whether a run can have it: a damaged memory may count any tick. Times lie within 146 years.
inline bool is_instant(long double nanoseconds) { return nanoseconds >= 0.0L && nanoseconds <= 0x1p62L; }

/// Instants at a constant rate, to the nearest nanosecond, counted from zero.
class Clock {
 public:
  explicit Clock(double rate) : rate_(rate) {}
  Time at(std::int64_t tick) const { return std::llround(nanoseconds_at(tick)); }
  /// The same, or never: for a rate of zero, beyond `end`, and for a tick without an instant.
  Time due(std::int64_t tick, Time end) const {
    return rate_ > 0.0 && is_instant(nanoseconds_at(tick)) && at(tick) <= end ? at(tick) : never;
  }
  double interval_before(std::int64_t tick) const { return seconds(at(tick) - at(tick - 1)); }

 private:
  double nanoseconds_at(std::int64_t tick) const { return static_cast<double>(tick) * 1e9 / rate_; }

  double rate_;  // Hz; 0: never
};

}  // namespace binnacle::simulation
