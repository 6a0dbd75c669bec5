// SPDX-License-Identifier: Apache-2.0
// A measurement as it would be seen from another state than the estimate; and from the sigma points of what it sees.
#include <algorithm>
#include <cstdio>

#include "filter/estimator.hpp"

namespace binnacle::internal::filter {

OtherStates::OtherStates(const FilterPlan& plan)
    : x(as_size(plan.stored_size)),
      by_column(as_size(plan.max_columns)),
      rows(plan),
      block_delta(as_size(plan.most_dof())),
      row(as_size(plan.most_dof())) {
  std::size_t most = 0;
  for (const auto& measurement : plan.measurements) most = std::max(most, measurement.memory.count);
  memory.resize(most);
}

SeenSigmaPoints::SeenSigmaPoints(const FilterPlan& plan)
    : points(plan.max_columns, plan.max_rows),
      P(plan.max_columns, plan.max_columns),
      residuals(plan.max_rows, 1 + 2 * plan.max_columns),
      fallback(plan.max_rows, plan.max_columns),
      M(plan.max_rows, plan.max_columns),
      Omega(plan.max_rows, plan.max_rows) {}

/// δ of one block, what is frozen in it zero.
VectorView Estimator::delta_elsewhere(const UpdatePlan::Seen& seen) {
  const BlockPlan& block = plan_.blocks[as_size(seen.block)];
  const VectorView delta(other_->block_delta.data(), block.dof());
  std::fill_n(delta.data(), delta.size(), 0.0);
  for (std::size_t a = 0; a < block.active.size(); ++a)
    delta[block.active[a]] = other_->by_column[as_size(seen.first_column) + a];
  return delta;
}

/// The rows of a sample at x̂ ⊞ δ, δ = OtherStates::by_column, with H by the error there.
Result Estimator::see_elsewhere(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now,
                                Jacobians wanted) {
  for (const auto& seen : measurement.update.seen) {
    const BlockPlan& block = plan_.blocks[as_size(seen.block)];
    const VectorView delta = delta_elsewhere(seen);
    const double* const x = state();
    calls_.during(block, "plus", [&] { block.block->plus(block.in(x), delta, block.in(other_->x.data())); });
  }
  roll_back(measurement);
  const Elsewhere elsewhere(*this, other_->x.data(), [&](const double* at) {
    for (const auto& seen : measurement.update.seen)
      values_[as_size(seen.block)] = at + plan_.blocks[as_size(seen.block)].stored_offset;
  });
  return run_parts(other_->rows, measurement, sample, now, wanted);
}

/// H̃ = H G: by the error at x̂. With truth = x̂ ⊞ δ* = (x̂ ⊞ δ) ⊞ ε, ε = G (δ* − δ) to first order.
void Estimator::reset_elsewhere(const MeasurementPlan& measurement) {
  SampleRows& rows = other_->rows;
  for (const auto& seen : measurement.update.seen) {
    const BlockPlan& block = plan_.blocks[as_size(seen.block)];
    const VectorView delta = delta_elsewhere(seen);
    const MatrixView G{block_jacobian_.data(), delta.size(), delta.size(), delta.size()};
    const double* const x = state();
    if (!calls_.during(block, "reset_jacobian", [&] { return block.block->reset_jacobian(block.in(x), delta, G); }))
      continue;
    const int dof = static_cast<int>(block.active.size());
    double* const first = rows.H + as_size(seen.first_column) * as_size(rows.m_max);
    const MatrixView H{first, rows.m, dof, rows.m_max};
    for (int i = 0; i < rows.m; ++i) {
      for (int c = 0; c < dof; ++c) {
        double sum = 0;
        for (int k = 0; k < dof; ++k) sum += H(i, k) * G(block.active[as_size(k)], block.active[as_size(c)]);
        other_->row[as_size(c)] = sum;
      }
      for (int c = 0; c < dof; ++c) H(i, c) = other_->row[as_size(c)];
    }
  }
}

/// Takes rows_, which are linearized at the estimate, to the regression on the sigma points of what they see:
///     r = Σ w r_i ,  H = −M ,  R ← R + Ω ,
/// so that S = H P Hᵀ + R is Σ w (r_i − r)(r_i − r)ᵀ + R. Where a point is refused or has other rows, they stay as they are.
Result Estimator::regress(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now) {
  const auto memory = measurement.memory;
  std::copy_n(memory.in(arena_), memory.count, other_->memory.data());
  bool is_whole = false;
  try {
    is_whole = see_sigma_points(measurement, sample, now);
  } catch (...) {
    roll_back(measurement);
    throw;
  }
  std::copy_n(other_->memory.data(), memory.count, memory.in(arena_));
  if (!is_whole) {
    was_linearized_instead_ = true;
    calls_.note_book.keep(measurement.parts.front().type, measurement.pointer, "linearize", calls_.time(),
                          "at a sigma point the sample is refused or has other rows: it is linearized instead");
    return Result::ok();
  }
  SeenSigmaPoints& its = *sigma_points_;
  const int m = rows_.m, columns = static_cast<int>(measurement.columns.size()), most = static_cast<int>(its.M.rows());
  const MatrixView H{rows_.H, m, columns, rows_.m_max}, fallback{its.fallback.data(), m, columns, most};
  const MatrixView M{its.M.data(), m, columns, most}, Omega{its.Omega.data(), m, m, most};
  fallback.as() = -H.as();
  its.points.regress(ConstMatrixView{its.residuals.data(), m, its.points.count(), most}, fallback,
                     {{rows_.r, m}, M, Omega});
  H.as() = -M.as();
  rows_.square(rows_.R_nominal.data()).as() += Omega.as();
  return Result::ok();
}

/// The residuals at all points; false where one has other rows than the centre.
bool Estimator::see_sigma_points(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now) {
  SeenSigmaPoints& its = *sigma_points_;
  const int m = rows_.m, columns = static_cast<int>(measurement.columns.size()), most = static_cast<int>(its.P.rows());
  const ConstMatrixView P = covariance();
  for (int j = 0; j < columns; ++j)
    for (int i = j; i < columns; ++i) its.P(i, j) = P(measurement.columns[as_size(i)], measurement.columns[as_size(j)]);
  its.points.factor({its.P.data(), columns, columns, most});
  std::copy_n(rows_.r, m, its.residuals.data());
  for (int point = 1; point < its.points.count(); ++point) {
    its.points.offset(point, {other_->by_column.data(), columns});
    if (!see_elsewhere(measurement, sample, now, Jacobians::none)) return false;
    const SampleRows& there = other_->rows;
    if (there.m != m || !std::equal(rows_.keys.begin(), rows_.keys.begin() + m, there.keys.begin()) ||
        !std::equal(rows_.groups.begin(), rows_.groups.begin() + m, there.groups.begin()))
      return false;
    std::copy_n(there.r, m, its.residuals.col(point).data());
  }
  return true;
}

}  // namespace binnacle::internal::filter
