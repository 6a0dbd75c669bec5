// SPDX-License-Identifier: Apache-2.0
// Intervals of samples whose begins nobody gave: from time to time, but over gaps.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "binnacle/time.hpp"

namespace binnacle::python {

struct Gaps {
  Time longer_than = 0;
  std::vector<std::size_t> ends;  // samples that end one
};

/// "2.5 s"
std::string seconds_text(Time t);

/// Steps longer than max_gap; where that is not given, of intervals longer than ten times the median step. As csv has it.
Gaps find_gaps(const std::vector<Time>& times, std::optional<Time> max_gap, bool has_intervals);
/// no_time for the first, unless they have a fixed length, and for those that end a gap.
std::vector<Time> starts_of(const std::vector<Time>& times, std::optional<Time> interval, const Gaps& gaps);
/// "3 gaps longer than 0.5 s, 4.9 s in all; the first from 1 s to 2 s; the longest, 2.9 s, ends at index 4"
std::string text_of(const Gaps& gaps, const std::vector<Time>& times);

}  // namespace binnacle::python
