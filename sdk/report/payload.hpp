// SPDX-License-Identifier: Apache-2.0
// What the page's script is given: results in display units, no longer than a plot can use.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "columns.hpp"
#include "report/comparison.hpp"
#include "report/page.hpp"
#include "track.hpp"
#include "update_figures.hpp"

namespace binnacle::report {

/// Beyond so many rows of one kind (satellites), one plot holds them all.
inline constexpr std::size_t most_row_plots = 6;

/// What is drawn of a filter of which not all was kept, and what is said of all of it.
struct DrawnFilter {
  struct ErrorFigures {
    std::size_t n = 0;
    Within within;             // of what is no length
    std::vector<double> nees;  // all of them, of a NEES
  };
  results::FilterResults series;       // its t: of the first row and of the last
  std::size_t rows = 0;                // that were recorded
  std::vector<std::vector<double>> t;  // by estimate
  std::vector<ErrorFigures> errors;    // by error
  std::vector<UpdateFigures> updates;  // by measurement
  results::FilterResults track;        // the block of the track, and the errors of its reference
};

/// How many series of a measurement are drawn.
std::size_t series_of(const results::Updates& updates);
/// Of each of so many series.
std::size_t most_points(std::size_t series, const Limits& limits);

/// No more than the longest of them has.
std::size_t points_per_series(const std::vector<results::FilterResults>& filters, const Limits& limits);
std::size_t points_per_series(const std::vector<const DrawnFilter*>& filters, const Limits& limits);

/// The page of a run whose filters are these, with the others of `results`.
std::string page_of(const results::Results& results, const std::vector<const DrawnFilter*>& drawn,
                    const Limits& limits);

/// { "title", "description", "run": { … }, "study": { … }, "columns": […] }
Json payload(const results::Results& results, const Limits& limits);
Json payload(const results::Results& results, const std::vector<const DrawnFilter*>& drawn, const Limits& limits);
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
/// Its filters, instead of those of `run`.
Json run_payload(const results::RunResults& run, const std::vector<const DrawnFilter*>& drawn, const Limits& limits,
                 Columns& columns);
Json study_payload(const results::StudyResults& study, Columns& columns);

}  // namespace binnacle::report
