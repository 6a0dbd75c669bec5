// SPDX-License-Identifier: Apache-2.0
#include "weights.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::robust {

namespace {

std::size_t as_size(std::int64_t n) { return static_cast<std::size_t>(n); }

/// One sample's weights. Rows of a block are reached through `member`.
class Solver {
 public:
  Solver(const Method& method, const Innovation& in, std::span<Row> rows, MatrixView R) noexcept
      : method_(method), in_(in), rows_(rows), R_(R), m_(in.rows) {
    divide();
    for (Row& row : rows_) row.weight = 1.0, row.is_held = 0;
  }

  void by_innovation() noexcept {
    for (int at = 0; at < m_; at += count_at(at)) weigh_innovation(at);
  }

  void by_residual() noexcept {
    factor_noise();
    for (int k = 0; k < method_.iterations; ++k) {
      if (!find_residual()) return;
      double change = 0.0;
      for (int at = 0; at < m_; at += count_at(at)) change = std::max(change, weigh_residual(at));
      if (change <= method_.tolerance) return;
    }
    findings_.has_converged = false;
  }

  Findings write() noexcept {
    for (const Row& row : rows_) findings_.is_at_least |= row.weight <= (1 + method_.tolerance) * least_weight;
    for (int j = 0; j < m_; ++j)
      for (int i = 0; i < m_; ++i) R_(i, j) = weighted(i, j);
    return findings_;
  }

 private:
  int member(int at) const noexcept { return static_cast<int>(rows_[as_size(at)].member); }
  const Row& row_at(int at) const noexcept { return rows_[as_size(member(at))]; }
  int count_at(int at) const noexcept { return static_cast<int>(row_at(at).count); }

  bool is_same(int i, int j) const noexcept {
    const auto a = as_size(i), b = as_size(j);
    switch (method_.unit) {
      case Unit::sample: return true;
      case Unit::part: return in_.row_groups[a] == in_.row_groups[b];
      case Unit::key: return in_.row_keys[a] == in_.row_keys[b];
      case Unit::row: break;
    }
    return i == j;
  }

  void divide() noexcept {
    for (Row& row : rows_) row.count = 0;
    int placed = 0;
    for (int i = 0; i < m_; ++i) {
      if (rows_[as_size(i)].count > 0) continue;
      const int first = placed;
      for (int j = i; j < m_; ++j)
        if (rows_[as_size(j)].count == 0 && is_same(i, j)) rows_[as_size(placed++)].member = j;
      for (int at = first; at < placed; ++at) rows_[as_size(member(at))].count = placed - first;
    }
  }

  double weighted(int i, int j) const noexcept {
    const double a = rows_[as_size(i)].weight, b = rows_[as_size(j)].weight;
    return in_.R_nominal(i, j) / (a == b ? a : std::sqrt(a * b));
  }

  double weight_of(int count, double squared) const noexcept {
    const double w = weight(method_.loss, method_.tuning[as_size(count - 1)], count, squared);
    return w >= least_weight ? w : least_weight;  // also where d² is not a number
  }

  void hold(int at) noexcept {
    findings_.is_held = true;
    for (int k = at; k < at + count_at(at); ++k) {
      Row& row = rows_[as_size(member(k))];
      row.weight = 1.0;
      row.is_held = 1;
    }
  }

  /// L of a block in R's lower triangle, in place of its matrix. False where it is not positive definite.
  bool factor(int at, int count) noexcept {
    for (int b = 0; b < count; ++b) {
      const int j = member(at + b);
      double pivot = R_(j, j);
      for (int k = 0; k < b; ++k) pivot -= R_(j, member(at + k)) * R_(j, member(at + k));
      if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
      const double root = R_(j, j) = std::sqrt(pivot);
      for (int a = b + 1; a < count; ++a) {
        const int i = member(at + a);
        double sum = R_(i, j);
        for (int k = 0; k < b; ++k) sum -= R_(i, member(at + k)) * R_(j, member(at + k));
        R_(i, j) = sum / root;
      }
    }
    return true;
  }

  // ---- of the innovation: each block by itself

  /// d² = rᵀ (HPHᵀ + R/w)⁻¹ r of one block; negative where that is no covariance.
  double squared_innovation(int at, int count, double w) noexcept {
    for (int b = 0; b < count; ++b)
      for (int a = b; a < count; ++a) {
        const int i = member(at + a), j = member(at + b);
        R_(i, j) = in_.HPHt(i, j) + in_.R_nominal(i, j) / w;
      }
    if (!factor(at, count)) return -1.0;
    double squared = 0.0;
    for (int a = 0; a < count; ++a) {
      const int i = member(at + a);
      double sum = in_.residual[i];
      for (int k = 0; k < a; ++k) sum -= R_(i, member(at + k)) * rows_[as_size(member(at + k))].y;
      const double y = rows_[as_size(i)].y = sum / R_(i, i);
      squared += y * y;
    }
    return squared;
  }

  /// w = W(d²(w)). d² grows with w, at most in proportion to it, and W falls with d², at most with its inverse square. So with
  /// u = ln w, f(u) = ln W − u has a slope between −3 and −1 and a single zero, and u ← u + f/2 halves what it is off.
  void weigh_innovation(int at) noexcept {
    const int count = count_at(at);
    for (int k = at; k < at + count; ++k)
      if (!(in_.R_nominal(member(k), member(k)) > 0.0)) return hold(at);
    double w = 1.0;
    for (int k = 0;; ++k) {
      const double squared = squared_innovation(at, count, w);
      if (squared < 0.0) return hold(at);
      const double wanted = weight_of(count, squared);
      if (std::abs(std::log(wanted / w)) <= method_.tolerance) break;
      if (k == method_.iterations) {
        findings_.has_converged = false;
        break;
      }
      w = std::sqrt(w * wanted);
    }
    for (int k = at; k < at + count; ++k) rows_[as_size(member(k))].weight = w;
  }

  // ---- of the update's residual: all blocks together

  /// The factors of the blocks of R: above the diagonal, their own in `root`.
  void factor_noise() noexcept {
    for (int at = 0; at < m_; at += count_at(at)) {
      const int count = count_at(at);
      for (int b = 0; b < count; ++b)
        for (int a = b; a < count; ++a)
          R_(member(at + a), member(at + b)) = in_.R_nominal(member(at + a), member(at + b));
      if (!factor(at, count)) {
        hold(at);
        continue;
      }
      for (int b = 0; b < count; ++b) {
        const int j = member(at + b);
        rows_[as_size(j)].root = R_(j, j);
        for (int a = b + 1; a < count; ++a) R_(j, member(at + a)) = R_(member(at + a), j);
      }
    }
  }

  /// v = R_w S_w⁻¹ r. False where S_w cannot be factored: the weights stay.
  bool find_residual() noexcept {
    for (int j = 0; j < m_; ++j) {
      double pivot = in_.HPHt(j, j) + weighted(j, j);
      for (int k = 0; k < j; ++k) pivot -= R_(j, k) * R_(j, k);
      if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
      R_(j, j) = std::sqrt(pivot);
      for (int i = j + 1; i < m_; ++i) {
        double sum = in_.HPHt(i, j) + weighted(i, j);
        for (int k = 0; k < j; ++k) sum -= R_(i, k) * R_(j, k);
        R_(i, j) = sum / R_(j, j);
      }
    }
    for (int i = 0; i < m_; ++i) {
      double sum = in_.residual[i];
      for (int k = 0; k < i; ++k) sum -= R_(i, k) * rows_[as_size(k)].y;
      rows_[as_size(i)].y = sum / R_(i, i);
    }
    for (int i = m_ - 1; i >= 0; --i) {
      double sum = rows_[as_size(i)].y;
      for (int k = i + 1; k < m_; ++k) sum -= R_(k, i) * rows_[as_size(k)].y;
      rows_[as_size(i)].y = sum / R_(i, i);
    }
    for (int i = 0; i < m_; ++i) {
      double sum = 0.0;
      for (int j = 0; j < m_; ++j) sum += weighted(i, j) * rows_[as_size(j)].y;
      rows_[as_size(i)].v = sum;
    }
    return true;
  }

  /// d² = vᵀ R⁻¹ v of one block gives its next weight. Returns by how much ln w changes.
  double weigh_residual(int at) noexcept {
    if (row_at(at).is_held) return 0.0;
    const int count = count_at(at);
    double squared = 0.0;
    for (int a = 0; a < count; ++a) {
      const int i = member(at + a);
      double sum = rows_[as_size(i)].v;
      for (int k = 0; k < a; ++k) sum -= R_(member(at + k), i) * rows_[as_size(member(at + k))].y;
      const double y = rows_[as_size(i)].y = sum / rows_[as_size(i)].root;
      squared += y * y;
    }
    const double old = row_at(at).weight, next = weight_of(count, squared);
    for (int k = at; k < at + count; ++k) rows_[as_size(member(k))].weight = next;
    return std::abs(std::log(next / old));
  }

  const Method& method_;
  const Innovation& in_;
  std::span<Row> rows_;
  MatrixView R_;
  int m_;
  Findings findings_;
};

}  // namespace

Findings write_weighted(const Method& method, const Innovation& in, std::span<Row> rows, MatrixView R) noexcept {
  Solver solver(method, in, rows, R);
  method.of == Whitened::residual ? solver.by_residual() : solver.by_innovation();
  return solver.write();
}

}  // namespace binnacle::robust
