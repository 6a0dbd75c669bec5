// SPDX-License-Identifier: Apache-2.0
// Time: signed nanoseconds on one clock per run.
#pragma once

#include <cstdint>
#include <limits>

namespace binnacle {

/// An instant or a duration in nanoseconds. Which epoch it counts from is the channel's own affair; all channels of
/// one run share it. int64 spans ±292 years, and differences are exact, so equal instants compare equal.
using Time = std::int64_t;

inline constexpr Time no_time = std::numeric_limits<Time>::min();
inline constexpr Time nanoseconds_per_second = 1'000'000'000;

/// Seconds in a duration [s].
constexpr double seconds(Time duration) noexcept { return static_cast<double>(duration) * 1e-9; }

/// The nearest nanosecond to a number of seconds, halves away from zero. |s| must be below 9.2e9.
constexpr Time nanoseconds(double s) noexcept {
  const double exact = s * 1e9, rest = exact - static_cast<double>(static_cast<Time>(exact));
  return static_cast<Time>(exact) + (rest >= 0.5) - (rest <= -0.5);
}

/// An instant: of the channels' clock, or counted from a filter's start ("start+60 s").
struct When {
  Time time = 0;
  bool from_start = false;
};

/// A stretch of time, both ends included; an end may count from the filter's start.
struct TimeSpan {
  Time from = no_time;
  Time to = no_time;
  bool from_is_relative = false;
  bool to_is_relative = false;

  bool contains(Time t, Time start) const {
    return t >= from + (from_is_relative ? start : 0) && t <= to + (to_is_relative ? start : 0);
  }
};

}  // namespace binnacle
