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
      integer("window").at_least(2).at_most(100000).defaults("50").about("N, samples of this measurement"),
      choice("from", {"innovation", "residual"})
          .defaults("\"residual\"")
          .about("C - HP-H' before the update, or C + HP+H' after it, which is never negative"),
      choice("shape", {"diagonal", "full"})
          .defaults("\"diagonal\"")
          .about("variances alone, with the correlations of the nominal R, or the matrix"),
      learn_below_parameter(),
  };
  for (ParameterSpec& bound : bounds_parameters("0.1")) spec.parameters.push_back(std::move(bound));
  spec.example = R"({ "window": 50, "from": "residual" })";
  return spec;
}

InnovationWindow::InnovationWindow(const Binding& binding, const NoiseBinding& noise)
    : window_(static_cast<int>(binding.parameters().integer("window"))),
      rows_(noise, Window::values(window_.length()), window_.length()),
      learn_below_(binding.parameters().number("learn_below")),
      bounds_(read_bounds(binding.parameters())),
      is_residual_(binding.parameters().text("from") == "residual"),
      is_full_(binding.parameters().text("shape") == "full") {}

std::size_t InnovationWindow::memory_bytes() const noexcept {
  const auto m = static_cast<std::size_t>(rows_.max_rows());
  return rows_.bytes() + (4 * m * m + 2 * m) * sizeof(double);
}

void InnovationWindow::start(std::byte* memory) const {
  rows_.start(memory);
  const int m = rows_.max_rows();
  std::fill_n(scratch(memory).estimate, 4 * m * m + 2 * m, 0.0);
}

InnovationWindow::Scratch InnovationWindow::scratch(std::byte* memory) const noexcept {
  const int square = rows_.max_rows() * rows_.max_rows();
  auto* const first = reinterpret_cast<double*>(memory + rows_.bytes());
  return {first, first + square, first + 2 * square, first + 3 * square, first + 4 * square};
}

void InnovationWindow::estimate(const Innovation& innovation, std::byte* memory, MatrixView R) const {
  rows_.enter(innovation, memory);
  window_.clear_place(rows_, memory);
  const Scratch own = scratch(memory);
  bool is_ready = true;
  for (int i = 0; i < innovation.rows; ++i) {
    own.learnt[i] = innovation.HPHt(i, i) <= learn_below_ * R(i, i) ? 1.0 : 0.0;
    const int slot = rows_.slot(memory, i);
    if (!is_residual_ && own.learnt[i] != 0.0) window_.push(rows_, slot, innovation.residual[i], memory);
    is_ready = is_ready && window_.is_full(rows_.values(memory, slot));
  }
  if (is_full_) {
    if (is_ready) write_full(innovation, memory, R);
  } else {
    write_diagonal(innovation, memory, R);
  }
}

double InnovationWindow::covariance(const Innovation& innovation, std::byte* memory, int i, int j) const noexcept {
  const int a = rows_.slot(memory, i), b = rows_.slot(memory, j);
  const double mean = window_.mean_product(rows_.values(memory, a), rows_.values(memory, b));
  return is_residual_ ? mean + scratch(memory).update[a + b * rows_.max_rows()] : mean - innovation.HPHt(i, j);
}

void InnovationWindow::write_diagonal(const Innovation& innovation, std::byte* memory, MatrixView R) const noexcept {
  double* const variance = scratch(memory).estimate;
  for (int i = 0; i < innovation.rows; ++i) {
    const bool is_ready = window_.is_full(rows_.values(memory, rows_.slot(memory, i)));
    const double found = is_ready ? covariance(innovation, memory, i, i) : R(i, i);
    variance[i] = std::isnan(found) ? R(i, i) : bounds_.clamped(found, R(i, i));
  }
  set_variances(variance, R);
}

void InnovationWindow::write_full(const Innovation& innovation, std::byte* memory, MatrixView R) const noexcept {
  const int m = innovation.rows;
  const Scratch own = scratch(memory);
  const MatrixView A{own.estimate, m, m, m}, L{own.root, m, m, m}, V{own.vectors, m, m, m};
  if (!factor(R, L)) return;
  for (int j = 0; j < m; ++j)
    for (int i = j; i < m; ++i) {
      A(i, j) = A(j, i) = covariance(innovation, memory, i, j);
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

void InnovationWindow::after(Outcome outcome, const double* residual, MatrixView HPHt_plus, std::byte* memory) const {
  if (outcome != Outcome::accepted) return;
  const Scratch own = scratch(memory);
  const int rows = rows_.rows(memory);
  for (int i = 0; i < rows; ++i) {
    const int a = rows_.slot(memory, i);
    if (own.learnt[i] != 0.0) window_.push(rows_, a, residual[i], memory);
    for (int j = 0; j < rows; ++j) own.update[a + rows_.slot(memory, j) * rows_.max_rows()] = HPHt_plus(i, j);
  }
}

}  // namespace binnacle::adaptive_noise
