// SPDX-License-Identifier: Apache-2.0
#include "filter/log_records.hpp"

#include <algorithm>

namespace binnacle::filter {

void LogRecords::allocate() {
  const auto n = as_size(plan_.n);
  x_before_.resize(as_size(plan_.stored_size));
  for (auto* matrix : {&P_before_, &Phi_, &Qd_, &reset_}) matrix->resize(n * n);
  H_.resize(as_size(plan_.max_rows) * n);
  variances_.resize(n);
}

void LogRecords::keep(bool keeps_P, const Estimator& estimator) {
  std::copy_n(estimator.state(), plan_.stored_size, x_before_.data());
  if (keeps_P) estimator.covariance().expand(square(P_before_));
}

StepRecord LogRecords::step(Wants wants, Time t0, Time t1, const Estimator& estimator) {
  StepRecord record;
  record.t0 = t0;
  record.t1 = t1;
  record.x0 = estimator.state();
  record.x1 = estimator.x_plus();
  if (includes(wants, Wants::step_covariance)) add_covariances(record, estimator);
  if (includes(wants, Wants::transition)) {
    expand_transition(plan_.transition, estimator.workspace().phi.data(), Phi_.data());
    expand_noise(plan_.transition, estimator.workspace().noise.data(), Qd_.data());
    record.Phi = square(Phi_);
    record.Qd = square(Qd_);
  }
  return record;
}

UpdateRecord LogRecords::innovation(Wants wants, const MeasurementPlan& measurement, const Estimator& estimator) {
  const SampleRows& rows = estimator.rows();
  UpdateRecord record;
  record.x0 = estimator.state();
  record.rows = rows.m;
  record.row_keys = rows.keys.data();
  record.row_groups = rows.groups.data();
  record.left_out = rows.left_out;
  record.left_out_keys = rows.left_out_keys.data();
  record.residual = rows.work.r;
  record.nis = rows.nis;
  record.S = rows.square(rows.work.S);
  record.R = rows.square(rows.work.R);
  if (!includes(wants, Wants::jacobian)) return record;
  record.H = {H_.data(), rows.m, plan_.n, rows.m};
  std::fill_n(H_.data(), as_size(rows.m) * as_size(plan_.n), 0.0);
  const auto& columns = measurement.columns;
  for (std::size_t c = 0; c < columns.size(); ++c)
    std::copy_n(rows.work.H + c * as_size(rows.work.m_max), rows.m, H_.data() + as_size(columns[c] * rows.m));
  return record;
}

UpdateRecord LogRecords::update(Wants wants, const MeasurementPlan& measurement, const Estimator& estimator) {
  const SampleRows& rows = estimator.rows();
  UpdateRecord record = innovation(wants, measurement, estimator);
  record.K = {rows.work.K, plan_.n, rows.m, padded(plan_.n)};
  record.delta = rows.delta.data();
  record.x0 = x_before_.data();
  record.x1 = estimator.state();
  if (includes(wants, Wants::update_covariance)) add_covariances(record, estimator);
  if (includes(wants, Wants::reset) && estimator.corrector().has_reset()) {
    record.reset = square(reset_);
    estimator.corrector().expand_reset(record.reset);
  }
  return record;
}

InflationRecord LogRecords::inflation(Wants wants, int measurement, Time t, const Estimator& estimator) {
  InflationRecord record;
  record.measurement = measurement;
  record.t = t;
  std::fill(variances_.begin(), variances_.end(), 0.0);
  for (const auto& inflation : plan_.measurements[as_size(measurement)].inflations)
    variances_[as_size(inflation.row)] += inflation.variance;
  record.variances = variances_.data();
  if (includes(wants, Wants::update_covariance)) add_covariances(record, estimator);
  return record;
}

}  // namespace binnacle::filter
