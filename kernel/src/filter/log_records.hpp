// SPDX-License-Identifier: Apache-2.0
// The step log's records, of what the observer wants and no more.
#pragma once

#include <vector>

#include "binnacle/step_log.hpp"
#include "filter/estimator.hpp"

namespace binnacle::filter {

class LogRecords {
 public:
  explicit LogRecords(const FilterPlan& plan) : plan_(plan) {}

  /// Once there is an observer; nothing is allocated afterwards.
  void allocate();

  /// Before P changes, by a step, a correction or an inflation: keeps it, and x.
  void keep(bool keeps_P, const Estimator& estimator);
  /// Between predict() and advance().
  StepRecord step(Wants wants, Time t0, Time t1, const Estimator& estimator);
  /// Of a sample that was linearized.
  UpdateRecord innovation(Wants wants, const MeasurementPlan& measurement, const Estimator& estimator);
  /// Of one that was accepted and has corrected.
  UpdateRecord update(Wants wants, const MeasurementPlan& measurement, const Estimator& estimator);
  InflationRecord inflation(Wants wants, int measurement, Time t, const Estimator& estimator);

 private:
  template <class Record>
  void add_covariances(Record& record, const Estimator& estimator) {
    record.P0 = square(P_before_);
    record.P1 = estimator.covariance().view();
  }
  MatrixView square(std::vector<double>& matrix) const { return {matrix.data(), plan_.n, plan_.n, plan_.n}; }

  const FilterPlan& plan_;
  std::vector<double> x_before_, P_before_, Phi_, Qd_, H_, reset_, variances_;
};

}  // namespace binnacle::filter
