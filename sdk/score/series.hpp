// SPDX-License-Identifier: Apache-2.0
// Errors over time, and what is made of them.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/state_bytes.hpp"
#include "binnacle/time.hpp"
#include "score/metric.hpp"

namespace binnacle::score {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// A named error over time; `values` in SI.
struct Series {
  std::string name;  // "position.horizontal"
  std::string unit;  // SI
  std::string display_unit;
  std::vector<Time> t;
  std::vector<double> values;

  void push(Time at, double value) {
    t.push_back(at);
    values.push_back(value);
  }
  void exchange(StateBytes& bytes) {
    bytes.list(t);
    bytes.list(values);
  }
};

/// {"mean", "rms", "p50", "p95", "max", "final", "n", "unit"} of the samples inside the span; null when there is none.
/// mean and final are signed, the others of the magnitude.
nlohmann::ordered_json statistics(const Series& series, const TimeSpan& span, Time start);

/// The metric's statistic of the values inside the span (`at`: wherever it is); NaN when there is none.
double over_time(const std::vector<Time>& t, const std::vector<double>& values, const Metric& metric,
                 const TimeSpan& span, Time start);

/// The p-quantile of the sorted values by linear interpolation between order statistics.
double quantile(const std::vector<double>& sorted, double p);

}  // namespace binnacle::score
