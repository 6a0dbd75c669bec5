// SPDX-License-Identifier: Apache-2.0
#include "filter/van_loan.hpp"

#include <algorithm>
#include <cmath>

#include "filter/layout.hpp"

namespace binnacle::filter {
namespace {

inline std::size_t at(int i, int j, int n) { return as_size(i) + as_size(j) * as_size(n); }

/// C = A B, or A Bᵀ.
template <bool is_transposed = false>
void multiply(const double* A, const double* B, int n, double* C) {
  std::fill_n(C, at(0, n, n), 0.0);
  for (int j = 0; j < n; ++j)
    for (int k = 0; k < n; ++k) {
      const double b = is_transposed ? B[at(j, k, n)] : B[at(k, j, n)];
      if (b == 0) continue;
      for (int i = 0; i < n; ++i) C[at(i, j, n)] += A[at(i, k, n)] * b;
    }
}

double norm_1(const double* A, int n) {
  double largest = 0;
  for (int j = 0; j < n; ++j) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += std::abs(A[at(i, j, n)]);
    largest = std::max(largest, sum);
  }
  return largest;
}

}  // namespace

std::size_t van_loan_doubles(int columns) { return 9 * at(0, columns, columns); }

void discretize(const double* F, const double* Q, int n, double dt, double* Phi, double* Qd, double* work) {
  const std::size_t size = at(0, n, n);
  double* const term = work;          // (F h)^k / k!
  double* const noise = work + size;  // k-th Taylor term of Qd
  double* const scratch = work + 2 * size;
  double* const other = work + 3 * size;

  int doublings = 0;
  const double reach = norm_1(F, n) * dt;
  if (reach > 0.25) doublings = std::max(0, static_cast<int>(std::ceil(std::log2(reach / 0.25))));
  const double h = std::ldexp(dt, -doublings);

  // Phi = Σ (F h)^k/k!;  Qd = Σ T_k with T_1 = Q h, T_{k+1} = (F T_k + T_k Fᵀ) h/(k+1).
  std::fill_n(Phi, size, 0.0);
  std::fill_n(term, size, 0.0);
  for (int i = 0; i < n; ++i) Phi[at(i, i, n)] = term[at(i, i, n)] = 1;
  for (std::size_t i = 0; i < size; ++i) Qd[i] = noise[i] = Q[i] * h;
  constexpr int order = 14;  // 0.5^15/15! < 1e-16 for Qd, whose terms grow twice as fast
  for (int k = 1; k <= order; ++k) {
    multiply(F, term, n, scratch);
    for (std::size_t i = 0; i < size; ++i) Phi[i] += term[i] = scratch[i] * (h / k);
    multiply(F, noise, n, scratch);
    multiply<true>(noise, F, n, other);
    for (std::size_t i = 0; i < size; ++i) Qd[i] += noise[i] = (scratch[i] + other[i]) * (h / (k + 1));
  }
  for (int d = 0; d < doublings; ++d) {
    multiply(Phi, Qd, n, scratch);
    multiply<true>(scratch, Phi, n, other);
    for (std::size_t i = 0; i < size; ++i) Qd[i] += other[i];
    multiply(Phi, Phi, n, scratch);
    std::copy_n(scratch, size, Phi);
  }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < j; ++i) Qd[at(i, j, n)] = Qd[at(j, i, n)] = 0.5 * (Qd[at(i, j, n)] + Qd[at(j, i, n)]);
}

}  // namespace binnacle::filter
