// SPDX-License-Identifier: Apache-2.0
// TimeBase: what a run's seconds count from.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "civil_time/utc_clock.hpp"
#include "results/results.hpp"

namespace binnacle::convert {

/// As it is given on a command line.
struct GivenTime {
  std::optional<std::int64_t> week;
  std::string epoch;
  std::optional<std::int64_t> leap_seconds;
};

struct TimeBase {
  civil_time::UtcClock clock;
  std::string text;  // "GPS week 2185, GPS - UTC by date"
  std::string from;  // "/sources/gnss of the config", "--week"
};

/// What is given, else what sources and sinks of the run's config say by "week" or "epoch". Nothing where none does.
/// Throws Refusal where two contradict each other `at` a time of the run, or what is given is wrong.
std::optional<TimeBase> time_base(const results::Json& config, const GivenTime& given, Time at);

}  // namespace binnacle::convert
