// SPDX-License-Identifier: Apache-2.0
#include "filter/corrector.hpp"

#include <algorithm>

namespace binnacle::filter {

Corrector::Corrector(const FilterPlan& plan, ModelCalls& calls)
    : plan_(plan), calls_(calls), x_plus_(as_size(plan.stored_size)), post_fit_(as_size(plan.max_rows)) {
  const std::size_t most = as_size(plan.most_dof());
  std::size_t squares = 0;
  for (const auto& block : plan.blocks) {
    squares += block.active.size() * block.active.size();
    if (!block.active.empty()) parts_.push_back({&block, block.dof(), block.is_whole()});
  }
  block_delta_.resize(most);
  jacobian_.resize(most * most);
  jacobians_.resize(squares);
  resets_.reserve(plan.blocks.size());
}

void Corrector::run(const MeasurementPlan& measurement, double* x, CovarianceForm& P, SampleRows& rows) {
  const auto& work = rows.work;
  gain(plan_.corrected.empty() ? nullptr : plan_.corrected.data(), plan_.n, rows.m, work);
  gain_times_residual(plan_.n, rows.m, work, rows.delta.data());
  inject(x, rows.delta.data());

  P.correct(rows.m, work);
  if (measurement.noise && measurement.noise->declaration().looks_back) {
    // To first order. G and HPHt are made anew with P⁺ and no longer those of the update.
    const auto& columns = measurement.columns;
    for (int i = 0; i < rows.m; ++i) {
      double predicted = 0;
      for (std::size_t c = 0; c < columns.size(); ++c)
        predicted += work.H[as_size(i) + c * as_size(work.m_max)] * rows.delta[as_size(columns[c])];
      post_fit_[as_size(i)] = work.r[i] - predicted;
    }
    P.project(measurement.columns, rows.m, work);
  }
  for (const auto& reset : resets_) P.transform(jacobians_.data() + reset.jacobian, reset.first, reset.dof);
  std::copy(x_plus_.begin(), x_plus_.end(), x);
}

void Corrector::inject(const double* x, const double* delta) {
  std::copy_n(x, x_plus_.size(), x_plus_.data());
  resets_.clear();
  for (const auto& part : parts_) {
    const BlockPlan& block = *part.block;
    const double* own = delta + block.first;
    if (!part.is_whole) {
      std::fill_n(block_delta_.data(), part.dof, 0.0);
      for (std::size_t a = 0; a < block.active.size(); ++a) block_delta_[as_size(block.active[a])] = own[a];
      own = block_delta_.data();
    }
    double* value = x_plus_.data() + block.stored_offset;
    calls_.plus(block, value, own, value);
    if (calls_.reset_jacobian(block, x + block.stored_offset, own, jacobian_.data())) find_reset(block);
  }
}

/// The active rows and columns of a block's reset Jacobian.
void Corrector::find_reset(const BlockPlan& block) {
  const std::size_t end =
      resets_.empty() ? 0 : resets_.back().jacobian + as_size(resets_.back().dof * resets_.back().dof);
  const int active = static_cast<int>(block.active.size()), dof = block.dof();
  double* G = jacobians_.data() + end;
  for (int c = 0; c < active; ++c)
    for (int r = 0; r < active; ++r)
      G[r + c * active] = jacobian_[as_size(block.active[as_size(r)] + block.active[as_size(c)] * dof)];
  resets_.push_back({block.first, active, end});
}

void Corrector::expand_reset(MatrixView T) const {
  T.as().setIdentity();
  for (const auto& reset : resets_)
    T.block(reset.first, reset.first, reset.dof, reset.dof).as() =
        matrix_at(jacobians_.data() + reset.jacobian, reset.dof, reset.dof);
}

}  // namespace binnacle::filter
