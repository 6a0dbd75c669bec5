// SPDX-License-Identifier: Apache-2.0
// Statistics over runs, with their standard errors.
#pragma once

#include <string>
#include <vector>

namespace binnacle::study {

/// Over the runs of a metric's values x. p50, p95 and max are of |x|, by linear interpolation between order statistics;
/// std has the divisor n − 1.
enum class OverRuns { mean, rms, std, p50, p95, max };

const std::vector<std::string>& over_runs_names();
OverRuns over_runs_named(const std::string& name);

/// NaN of no values; std needs two.
double over_runs(const std::vector<double>& x, OverRuns statistic);

/// Standard error by the delta method: the spread of the statistic's influence function over √n. That is std/√n for the
/// mean and std(x²)/(2 rms √n) for the rms. NaN for quantiles and max, and of fewer than two values.
double standard_error(const std::vector<double>& x, OverRuns statistic);

/// x's statistic over baseline's, and its standard error for paired values (run k of both drew the same numbers).
struct Ratio {
  double value = 0;
  double se = 0;
};
Ratio ratio_of(const std::vector<double>& x, const std::vector<double>& baseline, OverRuns statistic);

}  // namespace binnacle::study
