// SPDX-License-Identifier: Apache-2.0
// Scores a run: errors against reference channels and against withheld samples, over all and over windows.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/metric.hpp"
#include "binnacle/run.hpp"
#include "run/runtime.hpp"

namespace binnacle {

/// A named error over time; `values` in SI.
struct Series {
  std::string name;  // "position.horizontal"
  std::string unit;  // SI
  std::string display_unit;
  std::vector<Time> t;
  std::vector<double> values;
};

/// What a metric can be of: an error or a norm, or a whole block (for its NEES).
struct Scored {
  std::string name;  // "position.horizontal", "position"
  std::string unit;  // SI
  std::string display_unit;
  int index = 0;  // Metric::subject
  bool is_block = false;
  bool has_sigma = false;
  bool has_nees = false;
};

class Evaluator : public SampleListener {
 public:
  /// `step observers`: by filter, what else listens to it; null: nobody.
  explicit Evaluator(Runtime& runtime, const std::vector<StepObserver*>& observers = {});
  ~Evaluator() override;

  void sampled(int channel, const SampleView& sample) override;
  /// What still waits for its filter's next step is scored with the last estimate.
  void finish();
  nlohmann::ordered_json filter_summary(int filter) const;
  std::vector<Scored> scored(int filter) const;
  /// Before the run: what these metrics need beyond the errors is kept too.
  void watch(const std::vector<Metric>& metrics);
  /// Before the run: the 1-σ of every error is kept too.
  void keep_sigmas();
  /// RunObserver::scored() for everything there is.
  void tell_errors(RunObserver& observer) const;
  MetricValue value(const Metric& metric) const;
  /// Implied states and their 1-σ; NaN where there is none of this very time.
  std::vector<RecordColumn> implied_state_columns(int filter) const;
  void latest_implied_states(int filter, Time t, double* values) const;
  /// What noise estimators make of R, as 1-σ by group of rows; the newest values, NaN before the first.
  std::vector<RecordColumn> noise_columns(int filter) const;
  void latest_noise(int filter, double* values) const;
  /// Over all windows of all filters: mean, p50, max of each window's final and rms.
  nlohmann::ordered_json across_windows() const;

 private:
  class FilterScore;

  Runtime& runtime_;
  std::vector<std::unique_ptr<FilterScore>> scores_;
};

/// {"mean", "rms", "p50", "p95", "max", "final", "n", "unit"} of the samples inside the span; null when there is none.
/// mean and final are signed, the others of the magnitude.
nlohmann::ordered_json statistics(const Series& series, const TimeSpan& span, Time start);

/// The p-quantile of the sorted values by linear interpolation between order statistics.
double quantile(const std::vector<double>& sorted, double p);

}  // namespace binnacle
