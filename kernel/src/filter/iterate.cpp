// SPDX-License-Identifier: Apache-2.0
// An iterated update: the likeliest a-posteriori state, by Gauss and Newton's method on the manifold.
//
// Of all δ, x̂ ⊞ δ is the likeliest where
//     J(δ) = δᵀ P⁻¹ δ + rᵀ R⁻¹ r ,  r = z ⊟ h(x̂ ⊞ δ) ,
// is least (Bell and Cathey, The iterated Kalman filter update as a Gauss–Newton method, 1993). Linearized at δ_j, with G the
// reset Jacobian of the blocks,
//     H̃ = H_j G(x̂, δ_j) ,  r̃ = r_j + H̃ δ_j ,  δ_{j+1} = P H̃ᵀ (H̃ P H̃ᵀ + R)⁻¹ r̃ .
// δ is kept as P v, v = H̃ᵀ w, w = S⁻¹ r̃: then δᵀ P⁻¹ δ = vᵀ δ, and P may be singular. v has elements for what the measurement
// sees alone.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <utility>

#include "filter/estimator.hpp"

namespace binnacle::internal::filter {

namespace {

constexpr int most_halvings = 10;
constexpr double sufficient = 1e-4;  // share of what the linearization promises (Armijo)
constexpr double singular = 1e-14;   // share of a diagonal element of R

}  // namespace

Iteration::Iteration(const FilterPlan& plan) {
  const auto rows = as_size(plan.max_rows), columns = as_size(plan.max_columns), n = as_size(padded(plan.n));
  for (auto* row : {&r, &seen}) row->resize(rows);
  for (auto* square : {&S, &L_R}) square->resize(rows * rows);
  for (auto* state : {&delta, &next_delta, &tried_delta}) state->resize(n);
  for (auto* column : {&v, &next_v, &tried_v}) column->resize(columns);
}

/// x, P and the models' memories are as the first linearization left them, whatever the iterations come to.
Convergence Estimator::iterate(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now) {
  const auto memory = measurement.memory;
  std::copy_n(memory.in(arena_), memory.count, other_->memory.data());
  Convergence reached;
  try {
    reached = find_minimum(measurement, sample, now);
  } catch (...) {
    roll_back(measurement);
    std::copy_n(noise_backup_.data(), measurement.noise_memory.count, measurement.noise_memory.in(arena_));
    throw;
  }
  std::copy_n(other_->memory.data(), memory.count, memory.in(arena_));
  if (!reached.has_converged) {
    char text[sizeof KeptNote::text];
    std::snprintf(text, sizeof text, "the iterated update did not converge in %d linearizations", reached.iterations);
    calls_.note_book.keep(measurement.parts.front().type, measurement.pointer, "linearize", calls_.time(), text);
  }
  return reached;
}

/// What is injected, `delta` of the rows, is δ = K r̃ where the last step is a whole one, else δ itself, which has been
/// looked at. Where already the first step finds nothing better, it is made as it is.
Convergence Estimator::find_minimum(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now) {
  Iteration& it = *iteration_;
  begin_iteration();
  const auto& update = measurement.update;
  double cost = it.has_L_R ? whitened_square(it.L_R.data(), rows_.r, rows_.m, rows_.m_max, it.seen.data()) : 0;
  bool is_whole = true;
  for (int j = 1;; ++j) {
    solve_step(measurement);
    const double promised = square_of_step(measurement);
    if (promised <= update.tolerance * update.tolerance) return {j, true};
    const bool is_last = j == update.most;
    double share = 1;
    int halvings = 0;
    while (halvings <= most_halvings && !try_step(measurement, sample, now, share, promised, is_last, cost))
      ++halvings, share /= 2;
    const bool is_better = halvings <= most_halvings;
    if (is_better && !is_last) continue;
    is_whole = is_better ? halvings == 0 : j == 1;
    if (is_whole) return {j, false};
    rows_.has_delta = true;
    for (int i = 0; i < plan_.n; ++i)
      rows_.delta[as_size(i)] = plan_.corrected.empty() || plan_.corrected[as_size(i)] ? it.delta[as_size(i)] : 0.0;
    return {j, false};
  }
}

void Estimator::begin_iteration() {
  Iteration& it = *iteration_;
  const int m = rows_.m, ld = rows_.m_max;
  std::copy_n(rows_.r, m, it.r.data());
  rows_.innovation = it.r.data();
  if (rows_.innovation_S == rows_.S) rows_.innovation_S = std::copy_n(rows_.S, ld * m, it.S.data()) - ld * m;
  std::ranges::fill(it.delta, 0.0);
  std::ranges::fill(it.v, 0.0);
  it.has_L_R = factor_symmetric(rows_.R, m, ld, singular, it.L_R.data());
}

/// w = S⁻¹ r̃, v = H̃ᵀ w and δ = P v of the linearization in rows_.
void Estimator::solve_step(const MeasurementPlan& measurement) {
  Iteration& it = *iteration_;
  const int m = rows_.m, ld = rows_.m_max;
  double* const w = rows_.y;
  whitened_square(rows_.L, rows_.r, m, ld, w);
  for (int i = m - 1; i >= 0; --i) {
    for (int k = i + 1; k < m; ++k) w[i] -= rows_.L[k + i * ld] * w[k];
    w[i] /= rows_.L[i + i * ld];
  }
  for (std::size_t c = 0; c < measurement.columns.size(); ++c) {
    it.next_v[c] = 0;
    for (int i = 0; i < m; ++i) it.next_v[c] += rows_.H[as_size(i) + c * as_size(ld)] * w[i];
  }
  std::ranges::fill(it.next_delta, 0.0);
  for (int j = 0; j < m; ++j) {
    const double* const g = column_at(rows_.G, padded(plan_.n), j);
    for (int i = 0; i < plan_.n; ++i) it.next_delta[as_size(i)] += g[i] * w[j];
  }
}

/// Δᵀ (P⁻¹ + H̃ᵀ R⁻¹ H̃) Δ of the step Δ: in sigma of what will be known, and half of what J falls by at first along it.
/// Without an inverse of R, Δᵀ P⁻¹ Δ.
double Estimator::square_of_step(const MeasurementPlan& measurement) {
  Iteration& it = *iteration_;
  const int m = rows_.m, ld = rows_.m_max;
  double square = 0;
  std::fill_n(it.seen.data(), m, 0.0);
  for (std::size_t c = 0; c < measurement.columns.size(); ++c) {
    const auto row = as_size(measurement.columns[c]);
    const double step = it.next_delta[row] - it.delta[row];
    square += step * (it.next_v[c] - it.v[c]);
    for (int i = 0; i < m; ++i) it.seen[as_size(i)] += rows_.H[as_size(i) + c * as_size(ld)] * step;
  }
  // In place: row i is read before it is written, and none before it again.
  if (it.has_L_R) square += whitened_square(it.L_R.data(), it.seen.data(), m, ld, it.seen.data());
  return std::max(square, 0.0);
}

/// Goes a share of the way, if J becomes less by enough; there it is linearized anew, unless that is the end. What refuses the
/// sample, has not all of its rows or has no S is no place to go to. Without an inverse of R any place is.
bool Estimator::try_step(const MeasurementPlan& measurement, const SampleView& sample, const Driving& now, double share,
                         double promised, bool is_last, double& cost) {
  Iteration& it = *iteration_;
  SampleRows& there = other_->rows;
  for (std::size_t i = 0; i < it.delta.size(); ++i)
    it.tried_delta[i] = it.delta[i] + share * (it.next_delta[i] - it.delta[i]);
  double its_cost = 0;
  for (std::size_t c = 0; c < measurement.columns.size(); ++c) {
    other_->by_column[c] = it.tried_delta[as_size(measurement.columns[c])];
    it.tried_v[c] = it.v[c] + share * (it.next_v[c] - it.v[c]);
    its_cost += it.tried_v[c] * other_->by_column[c];
  }
  if (!see_elsewhere(measurement, sample, now, is_last ? Jacobians::none : Jacobians::wanted)) return false;
  if (!keep_rows(measurement)) return false;
  if (it.has_L_R) {
    its_cost += whitened_square(it.L_R.data(), there.r, there.m, there.m_max, it.seen.data());
    constexpr double rounding = 64 * std::numeric_limits<double>::epsilon();
    if (!(its_cost <= cost - 2 * sufficient * share * promised + rounding * cost)) return false;
  }
  if (!is_last && !linearize_tried(measurement)) return false;
  cost = its_cost;
  it.delta.swap(it.tried_delta);
  it.v.swap(it.tried_v);
  return true;
}

/// Of the rows there, those that were judged, in their order; false where one is missing.
bool Estimator::keep_rows(const MeasurementPlan& measurement) {
  SampleRows& there = other_->rows;
  const auto columns = measurement.columns.size();
  int k = 0;
  for (int i = 0; i < rows_.m; ++i, ++k) {
    while (k < there.m &&
           (there.groups[as_size(k)] != rows_.groups[as_size(i)] || there.keys[as_size(k)] != rows_.keys[as_size(i)]))
      ++k;
    if (k >= there.m) return false;
    there.r[i] = there.r[k];
    for (std::size_t c = 0; c < columns; ++c) {
      double* const column = there.H + c * as_size(there.m_max);
      column[i] = column[k];
    }
  }
  there.m = rows_.m;
  return true;
}

/// H̃, r̃ and S of the state tried become those of rows_; false where S is not positive definite.
bool Estimator::linearize_tried(const MeasurementPlan& measurement) {
  SampleRows& there = other_->rows;
  reset_elsewhere(measurement);
  for (std::size_t c = 0; c < measurement.columns.size(); ++c)
    for (int i = 0; i < there.m; ++i)
      there.r[i] += there.H[as_size(i) + c * as_size(there.m_max)] * other_->by_column[c];
  std::copy_n(rows_.R, rows_.m_max * rows_.m, there.R);
  P_->project(measurement.columns, there);
  if (P_->factor(measurement.columns, there)) {
    P_->factor(measurement.columns, rows_);  // which the correction is of then
    return false;
  }
  UpdateWork &a = rows_, &b = there;
  for (double* UpdateWork::*const part :
       {&UpdateWork::H, &UpdateWork::r, &UpdateWork::G, &UpdateWork::HPHt, &UpdateWork::S, &UpdateWork::L})
    std::swap(a.*part, b.*part);
  return true;
}

}  // namespace binnacle::internal::filter
