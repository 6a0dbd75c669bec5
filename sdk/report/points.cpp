// SPDX-License-Identifier: Apache-2.0
// How many points of a series are drawn.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "payload.hpp"

namespace binnacle::report {

namespace {

using results::FilterResults;
using results::Updates;

/// Values, their σ and their times, of everything that is plotted.
std::size_t series_of(const FilterResults& filter) {
  std::size_t series = 3 * (filter.estimates.size() + filter.errors.size());
  for (const auto& updates : filter.updates) series += report::series_of(updates);
  return series;
}

struct Size {
  std::size_t series = 0, longest = 0;
};

Size size_of(const FilterResults& filter) {
  std::size_t longest = filter.t.size();
  for (const auto& error : filter.errors) longest = std::max(longest, error.t.size());
  for (const auto& updates : filter.updates) longest = std::max(longest, updates.t.size());
  return {series_of(filter), longest};
}

Size size_of(const DrawnFilter& drawn) {
  std::size_t longest = drawn.rows;
  for (const auto& error : drawn.errors) longest = std::max(longest, error.n);
  for (const auto& updates : drawn.updates) longest = std::max(longest, updates.samples());
  return {series_of(drawn.series), longest};
}

template <class Filters, class Of>
std::size_t points_per_series(const Filters& filters, const Limits& limits, Of of) {
  Size all;
  for (const auto& filter : filters) {
    const Size size = size_of(of(filter));
    all.series += size.series;
    all.longest = std::max(all.longest, size.longest);
  }
  return std::min(all.longest, most_points(all.series, limits));
}

}  // namespace

std::size_t series_of(const Updates& updates) { return 4 * (1 + updates.groups.size() * most_row_plots); }

std::size_t most_points(std::size_t series, const Limits& limits) {
  return std::clamp(limits.numbers / std::max<std::size_t>(1, series), limits.least_points, limits.most_points);
}

std::size_t points_per_series(const std::vector<FilterResults>& filters, const Limits& limits) {
  return points_per_series(
      filters, limits, [](const auto& filter) -> const auto& { return filter; });
}

std::size_t points_per_series(const std::vector<const DrawnFilter*>& filters, const Limits& limits) {
  return points_per_series(
      filters, limits, [](const auto* filter) -> const auto& { return *filter; });
}

}  // namespace binnacle::report
