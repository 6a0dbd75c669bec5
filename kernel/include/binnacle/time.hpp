// SPDX-License-Identifier: Apache-2.0
// Time: signed nanoseconds on one clock per run.
#pragma once

#include <cmath>
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

/// The nearest nanosecond to a number of seconds. |s| must be below 9.2e9.
inline Time nanoseconds(double s) noexcept { return static_cast<Time>(std::llround(s * 1e9)); }

}  // namespace binnacle
