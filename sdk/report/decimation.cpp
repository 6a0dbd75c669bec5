// SPDX-License-Identifier: Apache-2.0
#include "decimation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace binnacle::report {

namespace {

constexpr std::size_t kind_count = 16;

void add_extremes(Series values, std::size_t begin, std::size_t end, std::vector<std::size_t>& kept) {
  std::size_t least = end, greatest = end;
  for (std::size_t i = begin; i < end; ++i) {
    if (std::isnan(values[i])) continue;
    if (least == end || values[i] < values[least]) least = i;
    if (greatest == end || values[i] > values[greatest]) greatest = i;
  }
  if (least == end) return;
  kept.push_back(least);
  kept.push_back(greatest);
}

void add_kinds(std::span<const std::uint8_t> kinds, std::size_t begin, std::size_t end,
               std::vector<std::size_t>& kept) {
  std::array<bool, kind_count> is_seen{};
  for (std::size_t i = begin; i < end; ++i) {
    auto& seen = is_seen[kinds[i] % kind_count];
    if (!seen) kept.push_back(i);
    seen = true;
  }
}

std::size_t kinds_in(std::span<const std::uint8_t> kinds) {
  std::array<bool, kind_count> is_seen{};
  for (const auto kind : kinds) is_seen[kind % kind_count] = true;
  return static_cast<std::size_t>(std::count(is_seen.begin(), is_seen.end(), true));
}

}  // namespace

std::vector<std::size_t> extremes_of_kinds(const std::vector<Series>& series, std::span<const std::uint8_t> kinds,
                                           std::size_t most) {
  const std::size_t n = series.empty() ? kinds.size() : series.front().size();
  std::vector<std::size_t> kept;
  if (n <= most) {
    kept.resize(n);
    std::iota(kept.begin(), kept.end(), std::size_t{0});
    return kept;
  }
  const std::size_t each = std::max<std::size_t>(1, 2 * series.size() + kinds_in(kinds));
  const std::size_t stretches = std::max<std::size_t>(1, (most < 2 ? 0 : most - 2) / each);
  kept.reserve(stretches * each + 2);
  kept.push_back(0);
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = n * s / stretches, end = n * (s + 1) / stretches;
    for (const auto& values : series) add_extremes(values, begin, end, kept);
    if (!kinds.empty()) add_kinds(kinds, begin, end, kept);
  }
  kept.push_back(n - 1);
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  return kept;
}

std::vector<std::size_t> extremes(const std::vector<Series>& series, std::size_t most) {
  return extremes_of_kinds(series, {}, most);
}

std::vector<std::size_t> extremes_in_time(const std::vector<Series>& series, std::span<const std::uint8_t> kinds,
                                          Series t, double width) {
  std::vector<std::size_t> kept;
  for (std::size_t begin = 0, end = 0; begin < t.size(); begin = end) {
    const double stretch = std::floor(t[begin] / width);
    while (end < t.size() && std::floor(t[end] / width) == stretch) ++end;
    for (const auto& values : series) add_extremes(values, begin, end, kept);
    add_kinds(kinds, begin, end, kept);
  }
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  return kept;
}

std::vector<std::size_t> spaced(Series x, Series y, double step) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    if (kept.empty() || std::hypot(x[i] - x[kept.back()], y[i] - y[kept.back()]) >= step) kept.push_back(i);
  }
  for (std::size_t i = x.size(); i-- > 0 && !kept.empty() && i > kept.back();)
    if (std::isfinite(x[i]) && std::isfinite(y[i])) {
      kept.push_back(i);
      break;
    }
  return kept;
}

}  // namespace binnacle::report
