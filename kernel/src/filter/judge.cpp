// SPDX-License-Identifier: Apache-2.0
#include "filter/judge.hpp"

#include <algorithm>
#include <cstring>
#include <limits>

#include "filter/noise_check.hpp"

namespace binnacle::filter {

Judge::Judge(const FilterPlan& plan, std::byte* arena, ModelCalls& calls)
    : plan_(plan), arena_(arena), calls_(calls), outlier_test_(plan.max_rows) {
  for (const auto& measurement : plan.measurements)
    noise_backup_.resize(std::max(noise_backup_.size(), measurement.noise_memory.count));
}

Judgement Judge::run(const MeasurementPlan& measurement, Time t, double dt, bool is_withheld, const CovarianceForm& P,
                     SampleRows& rows) {
  const auto& memory = measurement.noise_memory;
  if (memory.count > 0) std::memcpy(noise_backup_.data(), memory.in(arena_), memory.count);
  const auto roll_back_noise = [&] {
    if (memory.count > 0) std::memcpy(memory.in(arena_), noise_backup_.data(), memory.count);
  };
  P.project(measurement.columns, rows.m, rows.work);
  double nis_offered = 0;
  const auto gated = [&](const char* reason) -> Judgement {
    if (!measurement.learn_from_gated) roll_back_noise();
    rows.nis = nis_offered;
    return {Outcome::gated, reason};
  };
  for (const int offered = rows.m;;) {
    std::copy_n(rows.R_nominal.data(), rows.work.m_max * rows.m, rows.work.R);
    if (measurement.noise && !is_withheld) weigh(measurement, t, dt, rows);
    if (!factor_innovation(rows.m, rows.work)) {
      roll_back_noise();
      rows.nis = std::numeric_limits<double>::quiet_NaN();
      return {Outcome::rejected, "H P H' + R is not positive definite"};
    }
    rows.nis = normalized_innovation_squared(rows.m, rows.work);
    if (rows.left_out == 0) nis_offered = rows.nis;
    if (is_withheld || measurement.gate_unit == GateUnit::sample) break;
    bool is_majority = true;
    if (!leave_out_worst(measurement, offered, rows, is_majority)) break;
    if (!is_majority) return gated("no majority of its rows agrees with the rest");
    roll_back_noise();
  }
  if (is_withheld) return {Outcome::withheld, ""};
  if (measurement.gate > 0 && measurement.gate_unit == GateUnit::sample &&
      rows.nis > measurement.gate_limit[as_size(rows.m)])
    return gated("NIS beyond the gate");
  return {};
}

/// R by the noise estimator.
void Judge::weigh(const MeasurementPlan& measurement, Time t, double dt, SampleRows& rows) {
  Innovation innovation;
  innovation.t = t;
  innovation.dt = dt;
  innovation.rows = rows.m;
  innovation.row_keys = {rows.keys.data(), as_size(rows.m)};
  innovation.row_groups = {rows.groups.data(), as_size(rows.m)};
  innovation.residual = {rows.work.r, rows.m};
  innovation.HPHt = rows.square(rows.work.HPHt);
  innovation.R_nominal = rows.square(rows.R_nominal.data());
  const MatrixView R = rows.square(rows.work.R);
  calls_.estimate(measurement, innovation, R);
  if (!is_noise(R))
    throw Stop(call_text(measurement.noise_type, measurement.pointer, "estimate", t) + " gave " + flaw_of_noise(R));
}

/// False when no unit of rows is beyond its limit. Without a majority, the rows stay as they are.
bool Judge::leave_out_worst(const MeasurementPlan& measurement, int offered, SampleRows& rows, bool& is_majority) {
  const unsigned char* outliers =
      outlier_test_.find(measurement.gate_unit, measurement.gate_limit, rows.m, rows.keys.data(), rows.work);
  if (!outliers) return false;
  for (int i = 0; i < rows.m; ++i) {
    if (!outliers[i]) continue;
    const auto place = as_size(rows.left_out++);
    rows.left_out_groups[place] = measurement.gate_unit == GateUnit::key ? 0 : rows.groups[as_size(i)];
    rows.left_out_keys[place] = rows.keys[as_size(i)];
  }
  is_majority = 2 * rows.left_out <= offered;
  if (is_majority)
    rows.m = leave_out(outliers, rows.m, static_cast<int>(measurement.columns.size()), plan_.n, rows.R_nominal.data(),
                       rows.keys.data(), rows.groups.data(), rows.work);
  return true;
}

}  // namespace binnacle::filter
