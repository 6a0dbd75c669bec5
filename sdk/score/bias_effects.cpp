// SPDX-License-Identifier: Apache-2.0
#include "bias_effects.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

constexpr Time short_window = 30 * nanoseconds_per_second;
constexpr Time long_window = 600 * nanoseconds_per_second;  // b̂ of a bias since the start is of so long
constexpr Time long_step = nanoseconds_per_second / 10;
constexpr double significant = 3;          // σ of b̂: a bias since the start counts from there on
constexpr double one_sided_95 = 1.645;     // σ
constexpr double found_by = 4.5 + 1.2816;  // σ: about the limit of the verdict's tests, and 90 % of N(0, 1)

void add(double factor, const double* from, std::size_t count, double* to) {
  for (std::size_t c = 0; c < count; ++c) to[c] += factor * from[c];
}

/// The larger one; infinity once it is no number.
void see(double& largest, double value) {
  largest = std::isnan(value) ? std::numeric_limits<double>::infinity() : std::max(largest, value);
}

}  // namespace

BiasEffects::BiasEffects(const FilterInfo& filter) : filter_(filter), coupled_(as_size(filter.dof)) {
  const auto rows_of = [&](int block) {
    std::vector<int> rows(filter.blocks[as_size(block)].active.size());
    std::iota(rows.begin(), rows.end(), filter.blocks[as_size(block)].first_row);
    return rows;
  };
  for (const Coupling& coupling : filter.transition)
    for (const int row : rows_of(coupling.to))
      if (coupling.structure == Structure::diagonal)
        coupled_[as_size(row)].push_back(row);
      else
        for (const int column : rows_of(coupling.from)) coupled_[as_size(row)].push_back(column);
  std::vector<int> all(as_size(filter.dof));
  std::iota(all.begin(), all.end(), 0);
  if (filter.is_unscented) std::ranges::fill(coupled_, all);
  std::size_t m = 1;
  for (const auto& measurement : filter.measurements) m = std::max(m, as_size(measurement.max_rows));
  rows_.reserve(most_rows);
  for (auto* numbers : {&s_, &next_}) numbers->resize(coupled_.size() * stride);
  for (auto* numbers : {&J_, &d_}) numbers->resize(stride);
  g_.resize(m * stride);
  residual_.resize(m);
  factor_.resize(m * m);
  effects_.resize(coupled_.size() * most_rows);
  largest_sigma_.resize(coupled_.size());
}

bool BiasEffects::is_window_over() const { return newest_ >= window_begin_ + short_window; }

Wants BiasEffects::wants() const {
  Wants all = Wants::jacobian;
  if (newest_ + step_ >= propagated_ + long_step) all = all | Wants::transition;
  return is_window_over() ? all | Wants::update_covariance : all;
}

void BiasEffects::started(Time t) {
  newest_ = propagated_ = window_begin_ = long_begin_ = t;
  step_ = long_step;
  for (auto* numbers : {&s_, &J_, &d_}) std::ranges::fill(*numbers, 0.0);
}

void BiasEffects::stepped(const StepRecord& record) {
  if (record.t1 <= seen_until_) return;
  newest_ = record.t1;
  step_ = record.t1 - record.t0;
  if (!record.Phi) return;
  const double steps = std::max(1.0, seconds(record.t1 - propagated_) / seconds(step_));
  propagated_ = record.t1;
  for (int i = 0; i < filter_.dof; ++i) {
    double* const to = next_.data() + as_size(i) * stride;
    std::fill_n(to, columns(), 0.0);
    for (const int j : coupled_[as_size(i)])
      if (const double factor = record.Phi(i, j) - (i == j); factor != 0) add(steps * factor, s(j), columns(), to);
  }
  for (int i = 0; i < filter_.dof; ++i)
    if (!coupled_[as_size(i)].empty()) add(1, next_.data() + as_size(i) * stride, columns(), s(i));
}

const BiasEffects::Row* BiasEffects::find(int measurement, int group, std::int64_t key) const {
  const auto found = std::ranges::find_if(rows_, [&](const Row& row) {
    return row.measurement == measurement && row.group == group && row.key == key;
  });
  return found == rows_.end() ? nullptr : &*found;
}

void BiasEffects::offered(const UpdateRecord& record) {
  if (record.t <= seen_until_ || record.outcome != Outcome::accepted || !record.H) return;
  newest_ = std::max(newest_, record.t);
  const bool is_watched = filter_.measurements[as_size(record.measurement)].is_watched;
  for (int i = 0; i < record.rows && is_watched; ++i)
    if (rows_.size() < most_rows && !find(record.measurement, record.row_groups[i], record.row_keys[i]))
      rows_.push_back({record.row_keys[i], record.measurement, record.row_groups[i]});
  for (int i = 0; i < record.rows; ++i) {
    std::fill_n(g(i), columns(), 0.0);
    for (int j = 0; j < filter_.dof; ++j)
      if (const double factor = record.H(i, j); factor != 0) add(-factor, s(j), columns(), g(i));
    if (const Row* row = find(record.measurement, record.row_groups[i], record.row_keys[i])) {
      double* const its = g(i) + 2 * (row - rows_.data());
      its[0] += 1;
      its[1] += 1;
    }
  }
  for (int j = 0; j < filter_.dof; ++j)
    for (int i = 0; i < record.rows; ++i) add(record.K(j, i), g(i), columns(), s(j));
  whiten(record);
  for (int i = 0; i < record.rows; ++i) {
    for (std::size_t c = 0; c < columns(); ++c) J_[c] += g(i)[c] * g(i)[c];
    add(residual_[as_size(i)], g(i), columns(), d_.data());
  }
  if (record.P1 && is_window_over()) close_window(record.P1);
}

/// L⁻¹ g and L⁻¹ r, with S = L Lᵀ.
void BiasEffects::whiten(const UpdateRecord& record) {
  const auto L = [&](int i, int k) -> double& { return factor_[as_size(i * record.rows + k)]; };
  for (int i = 0; i < record.rows; ++i) {
    double& r = residual_[as_size(i)] = record.update_residual[i];
    for (int k = 0; k <= i; ++k) {
      L(i, k) = record.update_S(i, k);
      for (int l = 0; l < k; ++l) L(i, k) -= L(i, l) * L(k, l);
      if (k == i) break;
      L(i, k) /= L(k, k);
      r -= L(i, k) * residual_[as_size(k)];
      add(-L(i, k), g(k), columns(), g(i));
    }
    L(i, i) = std::sqrt(L(i, i));
    r /= L(i, i);
    for (std::size_t c = 0; c < columns(); ++c) g(i)[c] /= L(i, i);
  }
}

void BiasEffects::close_window(ConstMatrixView P) {
  for (int i = 0; i < filter_.dof; ++i) see(largest_sigma_[as_size(i)], std::sqrt(P(i, i)));
  const bool ends_long = newest_ >= long_begin_ + long_window;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::size_t of_start = 2 * row, of_window = 2 * row + 1;
    if (std::abs(d_[of_start]) > significant * std::sqrt(J_[of_start])) see_effects(of_start, P);
    see_effects(of_window, P);
    if (is_window_over()) see_unseen(row, P);
    for (int i = 0; i < filter_.dof; ++i) s(i)[of_window] = 0;
    J_[of_window] = d_[of_window] = 0;
    if (ends_long) J_[of_start] = d_[of_start] = 0;
  }
  window_begin_ = newest_;
  if (ends_long) long_begin_ = newest_;
}

void BiasEffects::see_effects(std::size_t column, ConstMatrixView P) {
  if (J_[column] == 0) return;
  const double bias = std::abs(d_[column]) / J_[column] + one_sided_95 / std::sqrt(J_[column]);
  for (int i = 0; i < filter_.dof; ++i) {
    Effect& worst = effects_[place(static_cast<std::ptrdiff_t>(column / 2), i)];
    const double effect = std::abs(s(i)[column]) * bias;
    see(worst.largest, effect);
    if (effect != 0) see(worst.of_3_sigma, effect / (3 * std::sqrt(P(i, i))));
  }
}

void BiasEffects::see_unseen(std::size_t row, ConstMatrixView P) {
  const std::size_t column = 2 * row + 1;
  if (!(J_[column] > 0)) return;
  Row& its = rows_[row];
  const auto in_sigma = [&](int i) { return P(i, i) > 0 ? std::abs(s(i)[column]) / std::sqrt(P(i, i)) : 0.0; };
  its.unseen_at = 0;
  for (int i = 1; i < filter_.dof; ++i)
    if (in_sigma(i) > in_sigma(its.unseen_at)) its.unseen_at = i;
  its.unseen = found_by / std::sqrt(J_[column]);
  its.unseen_for = seconds(newest_ - window_begin_);
  its.unseen_effect = std::abs(s(its.unseen_at)[column]) * its.unseen;
  its.unseen_in_sigma = in_sigma(its.unseen_at) * its.unseen;
}

void BiasEffects::exchange(StateBytes& bytes) {
  for (Time* t : {&newest_, &seen_until_, &propagated_, &step_, &window_begin_, &long_begin_}) bytes.value(*t);
  bytes.list(rows_);
  const bool is_right = rows_.size() <= most_rows && std::ranges::all_of(rows_, [&](const Row& row) {
                          return row.unseen_at >= -1 && row.unseen_at < filter_.dof;
                        });
  bytes.expect(is_right);
  if (bytes.is_reading() && !is_right) rows_.clear();
  for (auto* numbers : {&s_, &J_, &d_, &largest_sigma_})
    for (double& number : *numbers) bytes.value(number);
  for (Effect& effect : effects_) bytes.value(effect);
}

}  // namespace binnacle::score
