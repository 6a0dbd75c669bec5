// SPDX-License-Identifier: Apache-2.0
// What the page's script is given: results in display units, no longer than a plot can use.
#pragma once

#include <cstddef>

#include "columns.hpp"
#include "report/page.hpp"

namespace binnacle::report {

/// { "title", "description", "run": { … }, "study": { … }, "columns": […] }
Json payload(const results::Results& results, const Limits& limits);

Json run_payload(const results::RunResults& run, const Limits& limits, Columns& columns);
Json study_payload(const results::StudyResults& study, Columns& columns);

}  // namespace binnacle::report
