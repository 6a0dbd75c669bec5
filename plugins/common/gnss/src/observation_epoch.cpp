// SPDX-License-Identifier: Apache-2.0
#include "gnss/observation_epoch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "gnss/orbit.hpp"

namespace binnacle::gnss {

namespace {

constexpr double least_jump = 1e-4 * speed_of_light;  // m; receivers' clocks jump by milliseconds

}  // namespace

double clock_jump(const ObservationEpoch& before, const ObservationEpoch& now) {
  std::vector<double> steps;
  for (const Observation& of_now : now.satellites)
    for (const Observation& of_before : before.satellites) {
      if (of_now.satellite != of_before.satellite) continue;
      const double step = (of_now.pseudorange - of_now.phase) - (of_before.pseudorange - of_before.phase);
      if (std::isfinite(step)) steps.push_back(step);
    }
  if (steps.size() < 3) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  const double median = *middle;
  if (std::abs(median) < least_jump) return 0;
  // A clock moves all satellites' codes alike; phases that begin anew after a loss of lock do not.
  const auto agreeing =
      std::count_if(steps.begin(), steps.end(), [&](double step) { return std::abs(step - median) < 100.0; });
  return 2 * agreeing > static_cast<std::ptrdiff_t>(steps.size()) ? median : 0;
}

ClockJumps find_clock_jumps(std::vector<ObservationEpoch>& epochs) {
  std::size_t count = 0;
  const ObservationEpoch* first = nullptr;
  for (std::size_t i = 1; i < epochs.size(); ++i) {
    epochs[i].clock_jump = clock_jump(epochs[i - 1], epochs[i]);
    if (epochs[i].clock_jump != 0 && count++ == 0) first = &epochs[i];
  }
  if (!first) return {};
  char text[120];
  std::snprintf(text, sizeof text, "the receiver's clock jumps %zu time%s, the first at %.3f s by %.6f ms", count,
                count == 1 ? "" : "s", seconds(first->t), first->clock_jump / speed_of_light * 1e3);
  return {text, first->line};
}

}  // namespace binnacle::gnss
