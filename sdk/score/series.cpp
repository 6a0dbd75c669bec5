// SPDX-License-Identifier: Apache-2.0
#include "series.hpp"

#include <algorithm>
#include <cmath>

#include "binnacle/unit.hpp"

namespace binnacle::score {

double quantile(const std::vector<double>& sorted, double p) {
  const double at = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const auto above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

nlohmann::ordered_json statistics(const Series& series, const TimeSpan& span, Time start) {
  std::vector<double> magnitudes;
  double sum = 0, squares = 0, last = 0;
  for (std::size_t i = 0; i < series.t.size(); ++i) {
    if (!span.contains(series.t[i], start)) continue;
    const double value = series.values[i];
    magnitudes.push_back(std::abs(value));
    sum += value;
    squares += value * value;
    last = value;
  }
  if (magnitudes.empty()) return nullptr;
  std::sort(magnitudes.begin(), magnitudes.end());
  const double n = static_cast<double>(magnitudes.size());
  const auto unit = parse_unit(series.display_unit);
  const double scale = 1 / (unit ? unit->scale : 1.0);
  return {{"mean", sum / n * scale},
          {"rms", std::sqrt(squares / n) * scale},
          {"p50", quantile(magnitudes, 0.5) * scale},
          {"p95", quantile(magnitudes, 0.95) * scale},
          {"max", magnitudes.back() * scale},
          {"final", last * scale},
          {"n", magnitudes.size()},
          {"unit", series.display_unit.empty() ? series.unit : series.display_unit}};
}

namespace {

/// Between the two samples around the instant; NaN outside of them.
double interpolated(const std::vector<Time>& t, const std::vector<double>& values, Time at) {
  const auto above = static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), at) - t.begin());
  if (above == t.size()) return not_a_number;
  if (t[above] == at) return values[above];
  if (above == 0) return not_a_number;
  const double fraction = seconds(at - t[above - 1]) / seconds(t[above] - t[above - 1]);
  return values[above - 1] + fraction * (values[above] - values[above - 1]);
}

}  // namespace

double over_time(const std::vector<Time>& t, const std::vector<double>& values, const Metric& metric,
                 const TimeSpan& span, Time start) {
  if (metric.statistic == MetricStatistic::at)
    return interpolated(t, values, metric.at_is_from_start ? start + metric.at : metric.at);
  std::vector<double> inside;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (span.contains(t[i], start)) inside.push_back(values[i]);
  if (inside.empty()) return not_a_number;
  double sum = 0, squares = 0;
  for (const double value : inside) {
    sum += value;
    squares += value * value;
  }
  const double n = static_cast<double>(inside.size()), first = inside.front(), last = inside.back();
  for (double& value : inside) value = std::abs(value);
  switch (metric.statistic) {
    case MetricStatistic::mean: return sum / n;
    case MetricStatistic::rms: return std::sqrt(squares / n);
    case MetricStatistic::max: return *std::max_element(inside.begin(), inside.end());
    case MetricStatistic::final: return last;
    case MetricStatistic::drift: return last - first;
    default: break;
  }
  std::sort(inside.begin(), inside.end());
  return quantile(inside, metric.statistic == MetricStatistic::p50 ? 0.5 : 0.95);
}

}  // namespace binnacle::score
