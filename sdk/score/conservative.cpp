// SPDX-License-Identifier: Apache-2.0
#include "conservative.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "chi_squared_score.hpp"
#include "wording/short_number.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

constexpr std::int64_t enough_samples = 50;  // samples, as many as a window of the verdict has at least
constexpr double material = 0.5;             // mean NIS over what is expected: 0.71 of the standard deviations
// Correlation of innovations with those before them. Noise that is specified up to ten times too large leaves them white
// (0.27 in the quickstart); errors that persist do not (0.37 at least in configs/drives and configs/land).
constexpr double persisting = 0.3;
constexpr double alternating = -0.2;

/// Innovations of considered components are not white, even of a right filter.
bool is_considered(const FilterInfo& filter, const MeasurementInfo& measurement) {
  return std::ranges::any_of(measurement.blocks, [&](int block) {
    const auto& use = filter.blocks[as_size(block)].use;
    return std::ranges::find(use, "considered") != use.end();
  });
}

/// Of innovations with those before them, the mean of the rows.
double correlation_of(const std::vector<RowFigures>& rows) {
  double sum = 0;
  int count = 0;
  for (const RowFigures& row : rows)
    if (row.used >= enough_samples) {
      sum += row.correlation;
      ++count;
    }
  return count > 0 ? sum / count : 0;
}

}  // namespace

const char* likely_name(Likely likely) {
  constexpr const char* names[] = {"nothing", "sigma", "process_noise", "persisting_errors"};
  return names[static_cast<int>(likely)];
}

double share_inside_gate(double probability) {
  if (probability <= 0 || probability >= 1) return 1;
  double low = 0, high = 6;  // of x = z/√2, where P(|z| < limit) = erf(x)
  for (int i = 0; i < 60; ++i) {
    const double x = 0.5 * (low + high);
    (std::erf(x) < probability ? low : high) = x;
  }
  return 1 - 2 * low * std::exp(-low * low) / (std::sqrt(std::numbers::pi) * probability);
}

Conservative conservative(const FilterInfo& filter, const MeasurementInfo& measurement,
                          const MeasurementCounts& counts) {
  if (!measurement.is_watched || counts.nis_count < enough_samples || is_considered(filter, measurement)) return {};
  const double expected = counts.dof_mean * share_inside_gate(measurement.gate.probability);
  const double ratio = counts.nis_mean / expected;
  if (!(ratio < material) || chi_squared_score(ratio, expected * static_cast<double>(counts.nis_count)) > -rare_score)
    return {};
  const double correlation = correlation_of(counts.rows);
  const std::string figures = "'" + measurement.name + "' has a mean NIS of " + short_number(counts.nis_mean, 3) +
                              " over " + std::to_string(counts.nis_count) + " samples, and " +
                              short_number(expected, 3) + " is expected";
  const std::string innovations =
      "its innovations, correlated by " + short_number(correlation, 2) + " from sample to sample, ";
  if (correlation > persisting)
    return {Likely::persisting_errors,
            figures + "; " + innovations + "are those of errors that persist: the sigmas may be right"};
  if (correlation < alternating)
    return {Likely::process_noise, figures + "; " + innovations + "alternate: process noise may be too large"};
  return {Likely::sigma, figures + "; likely intent: standard deviations of about " +
                             short_number(std::sqrt(ratio), 2) + " of those specified"};
}

}  // namespace binnacle::score
