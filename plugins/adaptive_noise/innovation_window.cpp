// SPDX-License-Identifier: Apache-2.0
// R from the covariance of a window of innovations or residuals (Mohamed and Schwarz).
#include "innovation_window.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace binnacle::adaptive_noise {

namespace {

/// Lower Cholesky factor; false if the matrix is not positive definite.
bool factor(MatrixView A, MatrixView L) noexcept {
  const int m = A.rows;
  for (int j = 0; j < m; ++j) {
    double pivot = A(j, j);
    for (int k = 0; k < j; ++k) pivot -= L(j, k) * L(j, k);
    if (!(pivot > 0.0)) return false;
    L(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < m; ++i) {
      double sum = A(i, j);
      for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
      L(i, j) = sum / L(j, j);
    }
  }
  return true;
}

/// A ← L⁻¹ A L⁻ᵀ, A symmetric.
void whiten(MatrixView L, MatrixView A) noexcept {
  const int m = A.rows;
  for (int pass = 0; pass < 2; ++pass) {
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < m; ++i) {
        double sum = A(i, j);
        for (int k = 0; k < i; ++k) sum -= L(i, k) * A(k, j);
        A(i, j) = sum / L(i, i);
      }
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < j; ++i) std::swap(A(i, j), A(j, i));
  }
}

/// Jacobi's method: A becomes diagonal, V orthogonal with A_before = V A Vᵀ.
void diagonalize(MatrixView A, MatrixView V) noexcept {
  constexpr int sweeps = 16;
  const int m = A.rows;
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < m; ++i) V(i, j) = i == j ? 1.0 : 0.0;
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (int p = 0; p < m; ++p)
      for (int q = p + 1; q < m; ++q) {
        if (std::abs(A(p, q)) <= 1e-17 * std::sqrt(std::abs(A(p, p) * A(q, q)))) continue;
        const double theta = (A(q, q) - A(p, p)) / (2.0 * A(p, q));
        const double t = (theta < 0.0 ? -1.0 : 1.0) / (std::abs(theta) + std::hypot(theta, 1.0));
        const double c = 1.0 / std::hypot(t, 1.0), s = t * c;
        for (int k = 0; k < m; ++k) {
          const double kp = A(k, p), kq = A(k, q);
          A(k, p) = c * kp - s * kq, A(k, q) = s * kp + c * kq;
        }
        for (int k = 0; k < m; ++k) {
          const double pk = A(p, k), qk = A(q, k);
          A(p, k) = c * pk - s * qk, A(q, k) = s * pk + c * qk;
          const double vp = V(k, p), vq = V(k, q);
          V(k, p) = c * vp - s * vq, V(k, q) = s * vp + c * vq;
        }
      }
}

}  // namespace

ComponentSpec InnovationWindow::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "innovation_window";
  spec.summary = "R from the covariance of a window of innovations or residuals";
  spec.source =
      "A. H. Mohamed and K. P. Schwarz, Adaptive Kalman filtering for INS/GPS, Journal of Geodesy 73 (1999), 193-203, "
      "doi:10.1007/s001900050236";
  spec.parameters = {
      integer("window").at_least(2).at_most(100000).defaults("50").about(
          "length N of the window in samples of this measurement"),
      choice("from", {"innovation", "residual"})
          .defaults("\"residual\"")
          .about("source of R: C - HP-H' of the innovations before the update, or C + HP+H' of the residuals after it, "
                 "which is never negative"),
      choice("shape", {"diagonal", "full"})
          .defaults("\"diagonal\"")
          .about("estimated part of R: variances with the correlations of the nominal R, or the full matrix"),
      learn_below_parameter(),
  };
  for (ParameterSpec& bound : bounds_parameters("0.1")) spec.parameters.push_back(std::move(bound));
  spec.example = R"({ "window": 50, "from": "residual" })";
  return spec;
}

InnovationWindow::InnovationWindow(const Binding& binding, const NoiseBinding& noise)
    : window_(static_cast<int>(binding.parameters().integer("window"))),
      rows_(declaration_, noise, Window::values(window_.length()), window_.length()),
      learn_below_(binding.parameters().number("learn_below")),
      bounds_(read_bounds(binding.parameters())),
      is_residual_(binding.parameters().text("from") == "residual"),
      is_full_(binding.parameters().text("shape") == "full") {
  const auto m = static_cast<std::size_t>(rows_.max_rows());
  if (is_residual_) declaration_.wants_after();
  for (auto* square : {&estimate_, &root_, &vectors_, &update_}) *square = declaration_.keeps_array<double>(m * m);
  learnt_ = declaration_.keeps_array<double>(m);
}

void InnovationWindow::estimate(const Innovation& in, MatrixView R) const {
  const MemoryView& memory = in.memory;
  rows_.enter(in);
  window_.clear_place(rows_, memory);
  const auto learnt = memory[learnt_];
  bool is_ready = true;
  for (int i = 0; i < in.rows; ++i) {
    learnt[static_cast<std::size_t>(i)] = in.HPHt(i, i) <= learn_below_ * R(i, i) ? 1.0 : 0.0;
    const int slot = rows_.slot(memory, i);
    if (!is_residual_ && learnt[static_cast<std::size_t>(i)] != 0.0) window_.push(rows_, slot, in.residual[i], memory);
    is_ready = is_ready && window_.is_full(rows_.values(memory, slot));
  }
  if (is_full_) {
    if (is_ready) write_full(in, R);
  } else {
    write_diagonal(in, R);
  }
}

double InnovationWindow::covariance(const Innovation& in, int i, int j) const noexcept {
  const MemoryView& memory = in.memory;
  const int a = rows_.slot(memory, i), b = rows_.slot(memory, j);
  const double mean = window_.mean_product(rows_.values(memory, a), rows_.values(memory, b));
  return is_residual_ ? mean + memory[update_][static_cast<std::size_t>(a + b * rows_.max_rows())]
                      : mean - in.HPHt(i, j);
}

void InnovationWindow::write_diagonal(const Innovation& in, MatrixView R) const noexcept {
  double* const variance = in.memory[estimate_].data();
  for (int i = 0; i < in.rows; ++i) {
    const bool is_ready = window_.is_full(rows_.values(in.memory, rows_.slot(in.memory, i)));
    const double found = is_ready ? covariance(in, i, i) : R(i, i);
    variance[i] = std::isnan(found) ? R(i, i) : bounds_.clamped(found, R(i, i));
  }
  set_variances(variance, R);
}

void InnovationWindow::write_full(const Innovation& in, MatrixView R) const noexcept {
  const int m = in.rows;
  const auto square = [&](MemoryArray<double> array) { return MatrixView{in.memory[array].data(), m, m, m}; };
  const MatrixView A = square(estimate_), L = square(root_), V = square(vectors_);
  if (!factor(R, L)) return;
  for (int j = 0; j < m; ++j)
    for (int i = j; i < m; ++i) {
      A(i, j) = A(j, i) = covariance(in, i, j);
      if (std::isnan(A(i, j))) return;
    }
  whiten(L, A);
  diagonalize(A, V);
  for (int k = 0; k < m; ++k) A(k, k) = bounds_.clamped(A(k, k), 1.0);
  // (L V) Λ (L V)ᵀ, column by column of L V
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < m; ++i) R(i, j) = 0.0;
  for (int k = 0; k < m; ++k) {
    const double lambda = A(k, k);
    for (int i = m - 1; i >= 0; --i) {
      double sum = 0.0;
      for (int l = 0; l <= i; ++l) sum += L(i, l) * V(l, k);
      V(i, k) = sum;  // from below: row i of the product needs rows 0 … i of V
    }
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < m; ++i) R(i, j) += lambda * V(i, k) * V(j, k);
  }
}

void InnovationWindow::after(const AfterUpdate& in) const {
  if (in.outcome != Outcome::accepted) return;
  const MemoryView& memory = in.memory;
  const auto learnt = memory[learnt_], update = memory[update_];
  const int rows = rows_.rows(memory);
  for (int i = 0; i < rows; ++i) {
    const int a = rows_.slot(memory, i);
    if (learnt[static_cast<std::size_t>(i)] != 0.0) window_.push(rows_, a, in.residual[i], memory);
    for (int j = 0; j < rows; ++j)
      update[static_cast<std::size_t>(a + rows_.slot(memory, j) * rows_.max_rows())] = in.HPHt(i, j);
  }
}

}  // namespace binnacle::adaptive_noise
