// SPDX-License-Identifier: Apache-2.0
#include "filter/van_loan.hpp"

#include <algorithm>
#include <cmath>

#include "base/index.hpp"
#include "binnacle/view.hpp"

namespace binnacle::filter {
namespace {

using Matrix = Eigen::Map<Eigen::MatrixXd, Eigen::Unaligned>;
using ConstMatrix = Eigen::Map<const Eigen::MatrixXd, Eigen::Unaligned>;

/// C = A B, or A Bᵀ. Models are sparse.
template <bool is_transposed = false>
void multiply(const auto& A, const auto& B, Matrix& C) {
  C.setZero();
  for (int j = 0; j < C.cols(); ++j)
    for (int k = 0; k < C.cols(); ++k)
      if (const double b = is_transposed ? B(j, k) : B(k, j); b != 0) C.col(j) += A.col(k) * b;
}

double norm_1(const ConstMatrix& A) {
  double largest = 0;
  for (int j = 0; j < A.cols(); ++j) {
    double sum = 0;
    for (int i = 0; i < A.rows(); ++i) sum += std::abs(A(i, j));
    largest = std::max(largest, sum);
  }
  return largest;
}

}  // namespace

void discretize(const double* F_data, const double* Q_data, int n, double dt, double* Phi_data, double* Qd_data,
                double* work) {
  const std::size_t size = base::as_size(n) * base::as_size(n);
  const ConstMatrix F(F_data, n, n), Q(Q_data, n, n);
  Matrix Phi(Phi_data, n, n), Qd(Qd_data, n, n);
  Matrix term(work, n, n);          // (F h)^k / k!
  Matrix noise(work + size, n, n);  // k-th Taylor term of Qd
  Matrix scratch(work + 2 * size, n, n), other(work + 3 * size, n, n);

  int doublings = 0;
  const double reach = norm_1(F) * dt;
  if (reach > 0.25) doublings = std::max(0, static_cast<int>(std::ceil(std::log2(reach / 0.25))));
  const double h = std::ldexp(dt, -doublings);

  // Phi = Σ (F h)^k/k!;  Qd = Σ T_k with T_1 = Q h, T_{k+1} = (F T_k + T_k Fᵀ) h/(k+1).
  Phi.setIdentity();
  term.setIdentity();
  Qd = noise = Q * h;
  constexpr int order = 14;  // 0.5^15/15! < 1e-16 for Qd, whose terms grow twice as fast
  for (int k = 1; k <= order; ++k) {
    multiply(F, term, scratch);
    Phi += term = scratch * (h / k);
    multiply(F, noise, scratch);
    multiply<true>(noise, F, other);
    Qd += noise = (scratch + other) * (h / (k + 1));
  }
  for (int d = 0; d < doublings; ++d) {
    multiply(Phi, Qd, scratch);
    multiply<true>(scratch, Phi, other);
    Qd += other;
    multiply(Phi, Phi, scratch);
    Phi = scratch;
  }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < j; ++i) Qd(i, j) = Qd(j, i) = 0.5 * (Qd(i, j) + Qd(j, i));
}

}  // namespace binnacle::filter
