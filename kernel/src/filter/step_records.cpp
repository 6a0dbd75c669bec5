// SPDX-License-Identifier: Apache-2.0
// The step log's records, of what the observer wants and no more.
#include <algorithm>
#include <tuple>
#include <utility>

#include "filter/engine.hpp"

namespace binnacle::filter {

void Engine::attach(StepObserver* observer) {
  ledger_.attach(observer);
  if (!observer) return;
  const auto n = as_size(plan_.n);
  x_before_.resize(as_size(plan_.stored_size));
  for (auto* matrix : {&P_before_, &Phi_, &Qd_, &reset_}) matrix->resize(n * n);
  H_.resize(as_size(plan_.max_rows) * n);
  variances_.resize(n);
}

void Engine::keep_before(Wants wanted) {
  if (!ledger_.observer()) return;
  std::copy_n(state(), plan_.stored_size, x_before_.data());
  if (is_wanted(wanted)) square(P_before_).as() = covariance().as();
}

StepRecord Engine::step_record(Time t1) {
  StepRecord record{status().t, t1, state(), estimator_.x_plus(), {}, {}, {}, {}};
  if (is_wanted(Wants::step_covariance)) std::tie(record.P0, record.P1) = std::pair(square(P_before_), covariance());
  if (is_wanted(Wants::transition)) {
    record.Phi = square(Phi_);
    record.Qd = square(Qd_);
    expand_transition(plan_.transition, estimator_.phi(), record.Phi);
    expand_noise(plan_.transition, estimator_.noise(), record.Qd);
  }
  return record;
}

UpdateRecord Engine::innovation_record(const MeasurementPlan& measurement) {
  const SampleRows& rows = estimator_.rows();
  UpdateRecord record;
  record.x0 = state();
  record.rows = rows.m;
  record.row_keys = rows.keys.data();
  record.row_groups = rows.groups.data();
  record.left_out = rows.left_out;
  record.left_out_keys = rows.left_out_keys.data();
  record.residual = rows.r;
  record.nis = rows.nis;
  record.S = rows.square(rows.S);
  record.R = rows.square(rows.R);
  if (!is_wanted(Wants::jacobian)) return record;
  record.H = {H_.data(), rows.m, plan_.n, rows.m};
  record.H.as().setZero();
  const auto& columns = measurement.columns;
  for (std::size_t c = 0; c < columns.size(); ++c)
    std::copy_n(rows.H + c * as_size(rows.m_max), rows.m, H_.data() + as_size(columns[c] * rows.m));
  return record;
}

UpdateRecord Engine::update_record(const MeasurementPlan& measurement) {
  const SampleRows& rows = estimator_.rows();
  UpdateRecord record = innovation_record(measurement);
  record.K = {rows.K, plan_.n, rows.m, padded(plan_.n)};
  record.delta = rows.delta.data();
  record.x0 = x_before_.data();
  record.x1 = state();
  if (is_wanted(Wants::update_covariance)) std::tie(record.P0, record.P1) = std::pair(square(P_before_), covariance());
  if (is_wanted(Wants::reset) && estimator_.has_reset()) {
    record.reset = square(reset_);
    estimator_.expand_reset(record.reset);
  }
  return record;
}

InflationRecord Engine::inflation_record(int measurement, Time t) {
  std::fill(variances_.begin(), variances_.end(), 0.0);
  for (const auto& inflation : plan_.measurements[as_size(measurement)].inflations)
    variances_[as_size(inflation.row)] += inflation.variance;
  InflationRecord record{measurement, t, variances_.data(), {}, {}};
  if (is_wanted(Wants::update_covariance)) std::tie(record.P0, record.P1) = std::pair(square(P_before_), covariance());
  return record;
}

}  // namespace binnacle::filter
