// SPDX-License-Identifier: Apache-2.0
// What became of a filter's samples, as the summary of a run shows it.
#pragma once

#include <nlohmann/json.hpp>

#include "binnacle/session.hpp"

namespace binnacle::score {

/// { "measurements", "start_s", "end_s", "steps", "input_gaps", "filter_s", "broken" }
nlohmann::ordered_json run_figures(const Session& session, FilterId filter);

/// At the end of a run: a filter that never started is lost.
Verdict final_verdict(const Session& session, FilterId filter);

}  // namespace binnacle::score
