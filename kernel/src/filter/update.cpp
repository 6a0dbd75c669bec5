// SPDX-License-Identifier: Apache-2.0
// An update: how far a sample is trusted (noise estimator, NIS, gate by sample, row or key), and the correction by it.
#include <algorithm>
#include <limits>

#include "filter/estimator.hpp"

namespace binnacle::filter {

Judgement Estimator::judge(const MeasurementPlan& measurement, Time t, double dt, bool is_withheld) {
  const auto& memory = measurement.noise_memory;
  std::copy_n(memory.in(arena_), memory.count, noise_backup_.data());
  const auto roll_back_noise = [&] { std::copy_n(noise_backup_.data(), memory.count, memory.in(arena_)); };
  P_->project(measurement.columns, rows_);
  double nis_offered = 0;
  const auto gated = [&](const char* reason) -> Judgement {
    if (!measurement.learn_from_gated) roll_back_noise();
    rows_.nis = nis_offered;
    return {Outcome::gated, reason};
  };
  for (const int offered = rows_.m;;) {
    std::copy_n(rows_.R_nominal.data(), rows_.m_max * rows_.m, rows_.R);
    if (measurement.noise && !is_withheld) weigh(measurement, t, dt);
    if (!factor_innovation(rows_)) {
      roll_back_noise();
      rows_.nis = std::numeric_limits<double>::quiet_NaN();
      return {Outcome::rejected, "H P H' + R is not positive definite"};
    }
    rows_.nis = normalized_innovation_squared(rows_);
    if (rows_.left_out == 0) nis_offered = rows_.nis;
    if (is_withheld || measurement.gate_unit == GateUnit::sample) break;
    bool is_majority = true;
    if (!leave_out_worst(measurement, offered, is_majority)) break;
    if (!is_majority) return gated("no majority of its rows agrees with the rest");
    roll_back_noise();
  }
  if (is_withheld) return {Outcome::withheld, ""};
  if (measurement.gate > 0 && measurement.gate_unit == GateUnit::sample &&
      rows_.nis > measurement.gate_limit[as_size(rows_.m)])
    return gated("NIS beyond the gate");
  return {};
}

/// R by the noise estimator.
void Estimator::weigh(const MeasurementPlan& measurement, Time t, double dt) {
  const MatrixView R = rows_.square(rows_.R);
  const Innovation innovation{t,
                              dt,
                              rows_.m,
                              {rows_.keys.data(), as_size(rows_.m)},
                              {rows_.groups.data(), as_size(rows_.m)},
                              {rows_.r, rows_.m},
                              rows_.square(rows_.HPHt),
                              rows_.square(rows_.R_nominal.data()),
                              memory_of(measurement.noise_memory)};
  calls_.during(measurement.noise_type, measurement.pointer, "estimate",
                [&] { measurement.noise->estimate(innovation, R); });
  if (const std::string flaw = flaw_of_noise(R); !flaw.empty())
    throw Stop(call_text(measurement.noise_type, measurement.pointer, "estimate", t) + " gave " + flaw);
}

/// False when no unit of rows is beyond its limit. Without a majority, the rows stay as they are.
bool Estimator::leave_out_worst(const MeasurementPlan& measurement, int offered, bool& is_majority) {
  const unsigned char* outliers = outlier_test_.find(measurement.gate_unit, measurement.gate_limit, rows_);
  if (!outliers) return false;
  for (int i = 0; i < rows_.m; ++i) {
    if (!outliers[i]) continue;
    const auto place = as_size(rows_.left_out++);
    rows_.left_out_groups[place] = measurement.gate_unit == GateUnit::key ? 0 : rows_.groups[as_size(i)];
    rows_.left_out_keys[place] = rows_.keys[as_size(i)];
  }
  is_majority = 2 * rows_.left_out <= offered;
  if (is_majority) rows_.leave_out(outliers, static_cast<int>(measurement.columns.size()), plan_.n);
  return true;
}

// ---- the correction, and what the noise estimator sees of it

void Estimator::correct(const MeasurementPlan& measurement) {
  gain(plan_.corrected, plan_.n, rows_);
  gain_times_residual(plan_.n, rows_, rows_.delta.data());
  inject();
  P_->correct(rows_);
  if (measurement.noise && measurement.noise->declaration().looks_back) {
    // To first order, before the reset. G and HPHt are made anew with P⁺ and no longer those of the update.
    for (int i = 0; i < rows_.m; ++i) {
      double predicted = 0;
      for (std::size_t c = 0; c < measurement.columns.size(); ++c)
        predicted += rows_.H[as_size(i) + c * as_size(rows_.m_max)] * rows_.delta[as_size(measurement.columns[c])];
      post_fit_[as_size(i)] = rows_.r[i] - predicted;
    }
    P_->project(measurement.columns, rows_);
  }
  for (const auto& reset : resets_) P_->transform(reset.jacobian, reset.first, reset.dof);
  advance();
}

/// x⁺ = x ⊞ δ, and the reset Jacobians.
void Estimator::inject() {
  std::copy_n(state(), plan_.stored_size, x_plus_.data());
  resets_.clear();
  for (const auto& block : plan_.blocks) {
    if (block.active.empty()) continue;
    const VectorView delta(block_delta_.data(), block.dof()), value = block.in(x_plus_.data());
    delta.as().setZero();
    for (std::size_t a = 0; a < block.active.size(); ++a)
      delta[block.active[a]] = rows_.delta[as_size(block.first) + a];
    calls_.during(block, "plus", [&] { block.block->plus(value, delta, value); });
    const MatrixView G{block_jacobian_.data(), delta.size(), delta.size(), delta.size()};
    if (calls_.during(block, "reset_jacobian",
                      [&] { return block.block->reset_jacobian(block.in(state()), delta, G); }))
      keep_reset(block, G);
  }
}

/// The active rows and columns of a block's reset Jacobian.
void Estimator::keep_reset(const BlockPlan& block, MatrixView G) {
  const int dof = static_cast<int>(block.active.size());
  const MatrixView kept{reset_jacobians_.data() + block.first * plan_.n, dof, dof, dof};
  for (int c = 0; c < dof; ++c)
    for (int r = 0; r < dof; ++r) kept(r, c) = G(block.active[as_size(r)], block.active[as_size(c)]);
  resets_.push_back({block.first, dof, kept.data});
}

void Estimator::expand_reset(MatrixView T) const {
  T.as().setIdentity();
  for (const auto& reset : resets_)
    T.block(reset.first, reset.first, reset.dof, reset.dof).as() = matrix_at(reset.jacobian, reset.dof, reset.dof);
}

void Estimator::learn(const MeasurementPlan& measurement) {
  if (!measurement.noise || !measurement.noise->declaration().looks_back) return;
  const AfterUpdate in{Outcome::accepted,
                       {post_fit_.data(), rows_.m},
                       rows_.square(rows_.HPHt),
                       memory_of(measurement.noise_memory)};
  calls_.during(measurement.noise_type, measurement.pointer, "after", [&] { measurement.noise->after(in); });
}

}  // namespace binnacle::filter
