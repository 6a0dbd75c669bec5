// SPDX-License-Identifier: Apache-2.0
// What the page's script is given: results in display units, no longer than a plot can use.
#pragma once

#include <cstddef>

#include "columns.hpp"
#include "report/page.hpp"

namespace binnacle::report {

/// { "title", "description", "run": { … }, "study": { … }, "columns": […] }
Json payload(const results::Results& results, const Limits& limits);
/// { "live": state, "title", "description", "run": { … }, "columns": […] }
Json thinned_payload(const results::RunResults& run, const char* state, const Limits& limits);

/// All of a run's series, or a part of them: see live_payload().
enum class Extent { whole, thinned };
Json run_payload(const results::RunResults& run, const Limits& limits, Extent extent, Columns& columns);
Json study_payload(const results::StudyResults& study, Columns& columns);

}  // namespace binnacle::report
