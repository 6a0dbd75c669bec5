// SPDX-License-Identifier: Apache-2.0
// What the page's script is given: results in display units, no longer than a plot can use.
#pragma once

#include <cstddef>
#include <optional>

#include "columns.hpp"
#include "report/comparison.hpp"
#include "report/page.hpp"
#include "track.hpp"

namespace binnacle::report {

/// { "title", "description", "run": { … }, "study": { … }, "columns": […] }
Json payload(const results::Results& results, const Limits& limits);
/// { "live": state, "title", "description", "run": { … }, "columns": […] }
Json thinned_payload(const results::RunResults& run, const char* state, const Limits& limits);

/// { "title", "comparison": { … }, "run": { "filters": [ of all runs, as "RUN: FILTER" ], "summary", … }, "columns": […] };
/// "comparison" as Comparison::json(), and with it "keys": what each filter of it is called on the page, a run each.
Json comparison_payload(const std::vector<NamedRun>& runs, const Json& comparison, const Limits& limits);

/// All of a run's series, or a part of them: see live_payload().
enum class Extent { whole, thinned };
/// Geographic tracks about `origin`, or each about where it begins.
Json run_payload(const results::RunResults& run, const Limits& limits, Extent extent, Columns& columns,
                 const std::optional<TrackOrigin>& origin = {});
Json study_payload(const results::StudyResults& study, Columns& columns);

}  // namespace binnacle::report
