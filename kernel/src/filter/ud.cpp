// SPDX-License-Identifier: Apache-2.0
// Bierman, Factorization Methods for Discrete Sequential Estimation (1977), chapters V and VI; Thornton and Bierman, Gram-Schmidt
// algorithms for covariance propagation, Int. J. Control 25 (1977).
#include "filter/factored_form.hpp"

#include <algorithm>

#include "base/index.hpp"

namespace binnacle::internal::filter {

using base::as_size;

void Ud::put(int j, const double* x, double w) {
  double* const u = column_at(memory_, ld_, j);
  std::copy_n(x, j, u);
  u[j] = 1;
  std::fill(u + j + 1, u + ld_, 0.0);
  column_at(memory_, ld_, n_)[j] = w;
}

// d x xᵀ + w y yᵀ, x_j = 1 and y_j = b, is d' x' x'ᵀ + w' y' y'ᵀ with y'_j = 0 by Agee and Turner's formula for adding a rank
// of one (Bierman, III.A):
//     y' = y − b x ,  d' = d + w b² ,  x' = x + (w b / d') y' ,  w' = w d / d'.
// Thornton's Gram–Schmidt has the same result, but orthogonalizes by subtraction: with a prior of 1e30 next to a noise of 1,
// what is left of that is rounding. Here the first x is the heaviest column of its row, and nothing large cancels.
void Ud::eliminate(int j, int pivot, std::span<const int> others) {
  double* const __restrict x = column(pivot);
  double d = weights_[as_size(pivot)] * x[j] * x[j];
  const double scale = 1 / x[j];
  for (int i = 0; i < j; ++i) x[i] *= scale;
  for (const int other : others) {
    double* const __restrict y = column(other);
    double& w = weights_[as_size(other)];
    const double b = y[j];
    if (b == 0 || w == 0) continue;
    const double sum = d + w * b * b, step = w * b / sum;
    for (int i = 0; i < j; ++i) {
      y[i] -= b * x[i];
      x[i] += step * y[i];
    }
    w *= d / sum;
    d = sum;
  }
  put(j, x, d);
}

// Bierman, table V.3.1; r = 0 too, where nothing is divided by zero: as long as α is zero, so is k.
double Ud::update(double* memory, const double* f, double r, double* __restrict k) const {
  double* const d = column_at(memory, ld_, n_);
  double alpha = r;
  for (int j = 0; j < n_; ++j) {
    double* const __restrict u = column_at(memory, ld_, j);
    const double v = d[j] * f[j], before = alpha;
    alpha += f[j] * v;
    const double p = before > 0 ? -f[j] / before : 0.0;
    for (int i = 0; i < j; ++i) {
      const double own = u[i];
      u[i] += k[i] * p;
      k[i] += own * v;
    }
    k[j] = v;
    if (alpha > 0) d[j] *= before / alpha;
  }
  return alpha;
}

}  // namespace binnacle::internal::filter
