// SPDX-License-Identifier: Apache-2.0
// Parameters of a config by what the data say of them.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <nlohmann/json.hpp>

#include "tune/plan.hpp"

namespace binnacle::tune {

struct TuneOptions {
  std::uint64_t seed = 1;
  int run = 0;
  int jobs = 1;
  std::function<bool()> goes_on = [] { return true; };
  std::function<void(const std::string&)> on_round = [](const std::string&) {};
};

/// Thrown where `goes_on` says no.
struct Interrupted {};

/// { "objective", "parameters": [{"name", "start", "end", "standard_error", "interval", "evidence", "state"}], "undetermined",
/// "value": {"start", "end"}, "rounds", "gradient", "evaluations", "runs", "judged", "lowered", "patch", "notes" }. "lowered":
/// the rows that both ends accept are less likely at the end, so the patch is worse than what was there. Throws as
/// score::load() does, ConfigError (B130), FilterError where a filter breaks at the start.
Json tune(const Plan& plan, const TuneOptions& options);

}  // namespace binnacle::tune
