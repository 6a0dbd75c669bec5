// SPDX-License-Identifier: Apache-2.0
#include "array_intervals.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace binnacle::python {

std::string seconds_text(Time t) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g s", seconds(t));
  return text;
}

namespace {

/// No more than there are; labels may be centuries apart.
Time step(const std::vector<Time>& times, std::size_t i) {
  Time length = 0;
  return __builtin_sub_overflow(times[i], times[i - 1], &length) ? std::numeric_limits<Time>::max() : length;
}

Time usual_gap(const std::vector<Time>& times) {
  std::vector<Time> steps(times.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = step(times, i + 1);
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return 10 * std::min(*middle, std::numeric_limits<Time>::max() / 10);
}

}  // namespace

Gaps find_gaps(const std::vector<Time>& times, std::optional<Time> max_gap, bool has_intervals) {
  Gaps gaps{max_gap.value_or(std::numeric_limits<Time>::max()), {}};
  if (!max_gap && has_intervals && times.size() > 1) gaps.longer_than = usual_gap(times);
  for (std::size_t i = 1; i < times.size(); ++i)
    if (step(times, i) > gaps.longer_than) gaps.ends.push_back(i);
  return gaps;
}

std::vector<Time> starts_of(const std::vector<Time>& times, std::optional<Time> interval, const Gaps& gaps) {
  std::vector<Time> starts(times.size());
  starts[0] = interval ? times[0] - *interval : no_time;
  for (std::size_t i = 1; i < times.size(); ++i) starts[i] = interval ? times[i] - *interval : times[i - 1];
  for (const std::size_t i : gaps.ends) starts[i] = no_time;
  return starts;
}

std::string text_of(const Gaps& gaps, const std::vector<Time>& times) {
  const std::size_t first = gaps.ends.front();
  std::string text = std::to_string(gaps.ends.size()) + (gaps.ends.size() == 1 ? " gap" : " gaps") + " longer than " +
                     seconds_text(gaps.longer_than);
  const std::string from_to = " from " + seconds_text(times[first - 1]) + " to " + seconds_text(times[first]);
  if (gaps.ends.size() == 1) return text + ": " + seconds_text(step(times, first)) + from_to;
  Time total = 0;
  std::size_t longest = first;
  for (const std::size_t i : gaps.ends) {
    if (__builtin_add_overflow(total, step(times, i), &total)) total = std::numeric_limits<Time>::max();
    if (step(times, i) > step(times, longest)) longest = i;
  }
  return text + ", " + seconds_text(total) + " in all; the first" + from_to + "; the longest, " +
         seconds_text(step(times, longest)) + ", ends at index " + std::to_string(longest);
}

}  // namespace binnacle::python
