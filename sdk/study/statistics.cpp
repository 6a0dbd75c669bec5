// SPDX-License-Identifier: Apache-2.0
#include "study/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace binnacle::study {

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

double mean_of(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x) sum += value;
  return sum / static_cast<double>(x.size());
}

double rms_of(const std::vector<double>& x) {
  double squares = 0;
  for (const double value : x) squares += value * value;
  return std::sqrt(squares / static_cast<double>(x.size()));
}

double std_of(const std::vector<double>& x) {
  const double mean = mean_of(x);
  double squares = 0;
  for (const double value : x) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(x.size() - 1));
}

double quantile_of_magnitudes(std::vector<double> x, double p) {
  for (double& value : x) value = std::abs(value);
  std::sort(x.begin(), x.end());
  const double at = p * static_cast<double>(x.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const auto above = std::min(below + 1, x.size() - 1);
  return x[below] + (at - static_cast<double>(below)) * (x[above] - x[below]);
}

/// How much each value moves the statistic, times n: ψ with mean zero. Empty where there is none (quantiles).
std::vector<double> influence(const std::vector<double>& x, OverRuns statistic) {
  std::vector<double> psi;
  if (statistic == OverRuns::mean) {
    const double mean = mean_of(x);
    for (const double value : x) psi.push_back(value - mean);
  } else if (statistic == OverRuns::rms) {
    const double rms = rms_of(x);
    for (const double value : x) psi.push_back(rms > 0 ? (value * value - rms * rms) / (2 * rms) : 0);
  } else if (statistic == OverRuns::std) {
    const double mean = mean_of(x), n = static_cast<double>(x.size()), std = std_of(x);
    const double variance = std * std * (n - 1) / n;
    for (const double value : x)
      psi.push_back(std > 0 ? ((value - mean) * (value - mean) - variance) / (2 * std::sqrt(variance)) : 0);
  }
  return psi;
}

double spread(const std::vector<double>& psi) {
  const double n = static_cast<double>(psi.size());
  double squares = 0;
  for (const double value : psi) squares += value * value;
  return n < 2 ? not_a_number : std::sqrt(squares / (n - 1) / n);
}

}  // namespace

const std::vector<std::string>& over_runs_names() {
  static const std::vector<std::string> names{"mean", "rms", "std", "p50", "p95", "max"};
  return names;
}

OverRuns over_runs_named(const std::string& name) {
  const auto& names = over_runs_names();
  return static_cast<OverRuns>(std::find(names.begin(), names.end(), name) - names.begin());
}

double over_runs(const std::vector<double>& x, OverRuns statistic) {
  if (x.empty() || (statistic == OverRuns::std && x.size() < 2)) return not_a_number;
  switch (statistic) {
    case OverRuns::mean: return mean_of(x);
    case OverRuns::rms: return rms_of(x);
    case OverRuns::std: return std_of(x);
    case OverRuns::p50: return quantile_of_magnitudes(x, 0.5);
    case OverRuns::p95: return quantile_of_magnitudes(x, 0.95);
    default: return quantile_of_magnitudes(x, 1);
  }
}

double standard_error(const std::vector<double>& x, OverRuns statistic) {
  return x.size() < 2 ? not_a_number : spread(influence(x, statistic));
}

// a/b has the influence ψ_a/b − a ψ_b/b².
Ratio ratio_of(const std::vector<double>& x, const std::vector<double>& baseline, OverRuns statistic) {
  if (x == baseline && x.size() > 1) return {1, 0};  // not what rounding makes of it
  const double a = over_runs(x, statistic), b = over_runs(baseline, statistic);
  if (x.size() < 2 || x.size() != baseline.size()) return {a / b, not_a_number};
  auto psi = influence(x, statistic);
  const auto psi_b = influence(baseline, statistic);
  for (std::size_t i = 0; i < psi.size(); ++i) psi[i] = psi[i] / b - a * psi_b[i] / (b * b);
  return {a / b, spread(psi)};
}

}  // namespace binnacle::study
