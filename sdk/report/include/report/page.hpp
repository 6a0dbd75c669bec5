// SPDX-License-Identifier: Apache-2.0
// The report: what a run or a study left, as one HTML page that needs nothing else.
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

}  // namespace binnacle::report
