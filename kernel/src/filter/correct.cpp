// SPDX-License-Identifier: Apache-2.0
// A correction, and what the noise estimator sees of it.
#include <algorithm>

#include "filter/estimator.hpp"

namespace binnacle::filter {

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
