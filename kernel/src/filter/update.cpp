// SPDX-License-Identifier: Apache-2.0
// An update: how far a sample is trusted (noise estimator, NIS, gate by sample, row or key), and the correction by it.
#include <algorithm>
#include <limits>

#include <Eigen/Cholesky>

#include "filter/estimator.hpp"

namespace binnacle::internal::filter {

// ---- the rows, and which of them disagree with all others

SampleRows::SampleRows(const FilterPlan& plan) {
  const auto ld = as_size(padded(plan.n)), rows = as_size(plan.max_rows);
  H_.resize(rows * as_size(plan.max_columns));
  for (auto* square : {&R_, &HPHt_, &S_, &L_, &R_nominal, &S_nominal}) square->resize(rows * rows);
  for (auto* column : {&r_, &y_}) column->resize(rows);
  for (auto* tall : {&G_, &K_, &U_}) tall->resize(ld * std::max<std::size_t>(rows, 3));
  delta.resize(ld);
  for (auto* list : {&keys, &left_out_keys}) list->resize(rows);
  for (auto* list : {&mean_z, &mean_count, &left_out_r, &left_out_R, &post_fit}) list->resize(rows);
  biased.resize(rows);
  for (auto* list : {&groups, &left_out_groups}) list->resize(rows);
  static_cast<UpdateWork&>(*this) = {0,         plan.max_rows, H_.data(), R_.data(), r_.data(), G_.data(), HPHt_.data(),
                                     S_.data(), L_.data(),     K_.data(), U_.data(), y_.data()};
}

void SampleRows::begin(const MeasurementPlan& measurement) {
  m_max = measurement.max_rows;
  m = 0;
  left_out = removed = 0;
  nis = 0;
  innovation = r;
  judged_R = R;
  innovation_S = S;
  has_delta = false;
  std::fill_n(H, as_size(m_max) * measurement.columns.size(), 0.0);
  std::fill_n(R_nominal.data(), m_max * m_max, 0.0);
}

void SampleRows::keep_judged() {
  std::copy_n(S, m_max * m, S_nominal.data());
  innovation_S = S_nominal.data();
  judged_R = R_nominal.data();
}

void SampleRows::list_left_out(const unsigned char* marked) {
  for (int i = 0; i < m; ++i) {
    if (!marked[i]) continue;
    left_out_groups[as_size(left_out)] = groups[as_size(i)];
    left_out_r[as_size(left_out)] = r[i];
    left_out_R[as_size(left_out)] = R_nominal[as_size(i * (m_max + 1))];
    left_out_keys[as_size(left_out++)] = keys[as_size(i)];
  }
}

void SampleRows::remove(const unsigned char* marked, int columns, int n) {
  auto rows_of_H = MatrixView{H, m, columns, m_max}.as();
  auto columns_of_G = MatrixView{G, padded(n), m, padded(n)}.as();
  int kept = 0;
  for (int i = 0; i < m; ++i) {
    if (marked[i]) continue;
    rows_of_H.row(kept) = rows_of_H.row(i);
    columns_of_G.col(kept) = columns_of_G.col(i);
    for (double* matrix : {HPHt, R_nominal.data()}) {
      auto both = square(matrix).as();
      both.row(kept) = both.row(i);
      both.col(kept) = both.col(i);
    }
    r[kept] = r[i];
    keys[as_size(kept)] = keys[as_size(i)];
    groups[as_size(kept)] = groups[as_size(i)];
    ++kept;
  }
  removed += m - kept;
  m = kept;
}

OutlierTest::OutlierTest(int max_rows)
    : inverse_(max_rows, max_rows),
      z_(max_rows),
      part_(max_rows, max_rows),
      part_z_(max_rows),
      members_(as_size(max_rows)),
      is_tested_(as_size(max_rows)),
      worst_(as_size(max_rows)) {}

void OutlierTest::invert(const UpdateWork& work) {
  const int m = work.m;
  const auto L = ConstMatrixView{work.L, m, m, work.m_max}.as();
  auto inverse = inverse_.topLeftCorner(m, m);
  inverse.setIdentity();
  L.triangularView<Eigen::Lower>().solveInPlace(inverse);
  L.transpose().triangularView<Eigen::Upper>().solveInPlace(inverse);
  auto z = z_.head(m);
  z = Eigen::Map<const Eigen::VectorXd>(work.y, m);
  L.transpose().triangularView<Eigen::Upper>().solveInPlace(z);
}

double OutlierTest::statistic(int count) {
  if (count == 1) {
    const int row = members_[0];
    return z_[row] * z_[row] / inverse_(row, row);
  }
  auto A = part_.topLeftCorner(count, count);
  auto z = part_z_.head(count);
  for (int j = 0; j < count; ++j) {
    z[j] = z_[members_[as_size(j)]];
    for (int i = 0; i < count; ++i) A(i, j) = inverse_(members_[as_size(i)], members_[as_size(j)]);
  }
  Eigen::Ref<Eigen::MatrixXd> in_place(A);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(in_place);
  factor.matrixL().solveInPlace(z);
  return z.squaredNorm();
}

unsigned char* OutlierTest::find(GateUnit unit, const std::vector<double>& limit, const SampleRows& rows) {
  invert(rows);
  std::fill_n(is_tested_.begin(), rows.m, 0);
  double largest = 1.0;
  for (int row = 0; row < rows.m; ++row) {
    if (is_tested_[as_size(row)]) continue;
    int count = 0;
    for (int other = row; other < rows.m; ++other)
      if (other == row || (unit == GateUnit::key && rows.keys[as_size(other)] == rows.keys[as_size(row)])) {
        members_[as_size(count++)] = other;
        is_tested_[as_size(other)] = 1;
      }
    const double beyond = statistic(count) / limit[as_size(count)];
    if (!(beyond > largest)) continue;
    largest = beyond;
    std::fill_n(worst_.begin(), rows.m, 0);
    for (int k = 0; k < count; ++k) worst_[as_size(members_[as_size(k)])] = 1;
  }
  return largest > 1.0 ? worst_.data() : nullptr;
}

Judgement Estimator::judge(const MeasurementPlan& measurement, Time t, double dt, bool is_withheld,
                           LockOutTest is_locked_out) {
  const auto& memory = measurement.noise_memory;
  std::copy_n(memory.in(arena_), memory.count, noise_backup_.data());
  const auto roll_back_noise = [&] { std::copy_n(noise_backup_.data(), memory.count, memory.in(arena_)); };
  P_->project(measurement.columns, rows_);
  double nis_offered = 0;
  const auto locked_out = [&](const unsigned char* marked) -> Judgement {
    roll_back_noise();
    return {Outcome::gated, "", true, marked};
  };
  const auto gated = [&](const char* reason) -> Judgement {
    if (!measurement.learn_from_gated) roll_back_noise();
    rows_.nis = nis_offered;
    return {Outcome::gated, reason};
  };
  const auto without_factor = [&](const char* why_not) -> Judgement {
    roll_back_noise();
    rows_.nis = std::numeric_limits<double>::quiet_NaN();
    return {Outcome::rejected, why_not};
  };
  const bool is_weighed = measurement.noise && !is_withheld;
  const bool weighs_last = is_weighed && measurement.noise->declaration().is_judged_by_nominal;
  for (const int offered = rows_.m;;) {
    std::copy_n(rows_.R_nominal.data(), rows_.m_max * rows_.m, rows_.R);
    if (is_weighed && !weighs_last) weigh(measurement, t, dt);
    if (const char* const why_not = P_->factor(measurement.columns, rows_)) return without_factor(why_not);
    rows_.nis = normalized_innovation_squared(rows_);
    if (rows_.left_out == 0) nis_offered = rows_.nis;
    if (is_withheld || measurement.gate_unit == GateUnit::sample) break;
    unsigned char* const outliers = outlier_test_.find(measurement.gate_unit, measurement.gate_limit, rows_);
    if (!outliers) break;
    if (is_locked_out(rows_, outliers)) return locked_out(outliers);
    rows_.list_left_out(outliers);
    if (2 * rows_.left_out > offered) return gated("no majority of its rows agrees with the rest");
    rows_.remove(outliers, static_cast<int>(measurement.columns.size()), plan_.n);
    roll_back_noise();
  }
  if (is_withheld) return {Outcome::withheld, ""};
  if (measurement.gate > 0 && measurement.gate_unit == GateUnit::sample &&
      rows_.nis > measurement.gate_limit[as_size(rows_.m)]) {
    if (is_locked_out(rows_, nullptr)) return locked_out(nullptr);
    return gated("NIS beyond the gate");
  }
  if (weighs_last) {
    rows_.keep_judged();
    weigh(measurement, t, dt);
    if (const char* const why_not = P_->factor(measurement.columns, rows_)) return without_factor(why_not);
  }
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
                              memory_of(measurement.noise_memory),
                              calls_.notes()};
  calls_.during(measurement.noise_type, measurement.pointer, "estimate",
                [&] { measurement.noise->estimate(innovation, R); });
  if (const std::string flaw = flaw_of_noise(R); !flaw.empty())
    throw Stop(call_text(measurement.noise_type, measurement.pointer, "estimate", t) + " gave " + flaw);
}

// ---- the correction, and what the noise estimator sees of it

void Estimator::correct(const MeasurementPlan& measurement) {
  P_->gain(plan_.corrected, rows_);
  if (!rows_.has_delta) gain_times_residual(plan_.n, rows_, rows_.delta.data());
  inject();
  P_->correct(plan_.corrected, rows_);
  const bool looks_back = measurement.noise && measurement.noise->declaration().looks_back;
  if (looks_back || measurement.widens) {
    // To first order, before the reset. G and HPHt are made anew with P⁺ and no longer those of the update.
    for (int i = 0; i < rows_.m; ++i) {
      double predicted = 0;
      for (std::size_t c = 0; c < measurement.columns.size(); ++c)
        predicted += rows_.H[as_size(i) + c * as_size(rows_.m_max)] * rows_.delta[as_size(measurement.columns[c])];
      rows_.post_fit[as_size(i)] = rows_.r[i] - predicted;
    }
  }
  if (looks_back) P_->project(measurement.columns, rows_);
  for (const auto& reset : resets_) P_->transform(reset.jacobian, reset.first, reset.dof);
  note_rounded();
  std::ranges::copy(x_corrected_, x());
}

void Estimator::note_rounded() {
  for (const int row : P_->rounded())
    for (const auto& block : plan_.blocks) {
      if (row < block.first || row >= block.first + base::count_of(block.active)) continue;
      calls_.note_book.keep(block.type, block.pointer, "update", calls_.time(),
                            "a variance came out below zero by rounding, and was set to zero with its row and column");
    }
}

/// x⁺ = x ⊞ δ, and the reset Jacobians.
void Estimator::inject() {
  std::copy_n(state(), plan_.stored_size, x_corrected_.data());
  resets_.clear();
  for (const auto& block : plan_.blocks) {
    if (block.active.empty()) continue;
    const bool is_whole = block.is_whole();  // then δ and G need no copies with zeros for what is frozen
    double* const own = rows_.delta.data() + block.first;
    const VectorView delta(is_whole ? own : block_delta_.data(), block.dof()), value = block.in(x_corrected_.data());
    if (!is_whole) std::fill_n(delta.data(), delta.size(), 0.0);
    for (std::size_t a = 0; a < block.active.size() && !is_whole; ++a) delta[block.active[a]] = own[a];
    calls_.during(block, "plus", [&] { block.block->plus(value, delta, value); });
    const MatrixView G{is_whole ? kept_G(block) : block_jacobian_.data(), delta.size(), delta.size(), delta.size()};
    if (calls_.during(block, "reset_jacobian",
                      [&] { return block.block->reset_jacobian(block.in(state()), delta, G); }))
      keep_reset(block, G);
  }
}

/// The active rows and columns of a block's reset Jacobian.
void Estimator::keep_reset(const BlockPlan& block, MatrixView G) {
  const int dof = static_cast<int>(block.active.size());
  const MatrixView kept{kept_G(block), dof, dof, dof};
  for (int c = 0; c < dof && G.data != kept.data; ++c)
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
                       {rows_.post_fit.data(), rows_.m},
                       rows_.square(rows_.HPHt),
                       memory_of(measurement.noise_memory)};
  calls_.during(measurement.noise_type, measurement.pointer, "after", [&] { measurement.noise->after(in); });
}

}  // namespace binnacle::internal::filter
