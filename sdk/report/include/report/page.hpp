// SPDX-License-Identifier: Apache-2.0
// The report: what a run or a study left, or a run that goes on, as one HTML page.
#pragma once

#include <cstddef>
#include <string>

#include "results/results.hpp"

namespace binnacle::report {

/// All series of a page together hold no more numbers than this; one series no more points than `most_points`, and, in
/// pages with very many series, no fewer than a plot is wide. What is left out lies between the minimum and the maximum
/// that are shown.
struct Limits {
  std::size_t numbers = 1'500'000;
  std::size_t most_points = 20'000;
  std::size_t least_points = 1'000;
};

std::string page(const results::Results& results, const Limits& limits = {});

// ---- of a run that goes on

/// What such a page draws of one series is thinned already, and is sent anew with every change.
inline constexpr Limits live_limits{200'000, 2'100, 300};

/// The same page without series: it asks its server for "events", each of them a live_payload(). Of `run`: config and
/// provenance.
std::string live_page(const results::RunResults& run);

/// What the page draws from then on, as one line of JSON. The series of `run` are a part of what was seen: numbers of samples
/// and NIS are those of its summary, and no shares, means or reasons are made of the series.
std::string live_payload(const results::RunResults& run, bool is_over, const Limits& limits = live_limits);

}  // namespace binnacle::report
