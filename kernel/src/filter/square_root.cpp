// SPDX-License-Identifier: Apache-2.0
// Carlson, Fast triangular formulation of the square root filter, AIAA Journal 11 (1973).
#include "filter/factored_form.hpp"

#include <algorithm>
#include <cmath>

#include "base/index.hpp"

namespace binnacle::internal::filter {

using base::as_size;

void SquareRoot::put(int j, const double* x, double w) {
  double* const s = column_at(memory_, ld_, j);
  const double root = std::sqrt(w);
  for (int i = 0; i < j; ++i) s[i] = root * x[i];
  s[j] = root;
  std::fill(s + j + 1, s + ld_, 0.0);
}

// Givens rotations. Householder's reflections would cost as much, but mix rows of 1e15 and 1 where only rotations keep the small
// one's digits.
void SquareRoot::eliminate(int j, int pivot, std::span<const int> others) {
  double* const __restrict x = column(pivot);
  const auto take_weight = [&](int k) {
    double& w = weights_[as_size(k)];
    if (w == 1) return;
    const double root = std::sqrt(w);
    double* const y = column(k);
    for (int i = 0; i <= j; ++i) y[i] *= root;
    w = 1;
  };
  take_weight(pivot);
  double a = x[j];
  for (const int other : others) {
    double* const __restrict y = column(other);
    if (y[j] == 0 || weights_[as_size(other)] == 0) continue;
    take_weight(other);
    const double b = y[j], ratio = b / a, length = a * std::sqrt(1 + ratio * ratio);
    const double cosine = a / length, sine = b / length;
    for (int i = 0; i < j; ++i) {
      const double own = x[i];
      x[i] = cosine * own + sine * y[i];
      y[i] = cosine * y[i] - sine * own;
    }
    a = length;
  }
  double* const s = column_at(memory_, ld_, j);
  const double sign = a < 0 ? -1 : 1;
  for (int i = 0; i < j; ++i) s[i] = sign * x[i];
  s[j] = sign * a;
  std::fill(s + j + 1, s + ld_, 0.0);
}

// With α_j = α_{j−1} + f_j², k the sum of s_l f_l over l < j:
//     s_j ← √(α_{j−1}/α_j) s_j − f_j / √(α_{j−1} α_j) k.
double SquareRoot::update(double* memory, const double* f, double r, double* __restrict k) const {
  double alpha = r;
  for (int j = 0; j < n_; ++j) {
    double* const __restrict s = column_at(memory, ld_, j);
    const double before = alpha;
    alpha += f[j] * f[j];
    if (f[j] == 0 || !(alpha > 0)) {
      k[j] = 0;
      continue;
    }
    const double keep = std::sqrt(before / alpha);
    const double take = before > 0 ? f[j] / (std::sqrt(before) * std::sqrt(alpha)) : 0.0;
    for (int i = 0; i < j; ++i) {
      const double own = s[i];
      s[i] = keep * own - take * k[i];
      k[i] += own * f[j];
    }
    k[j] = s[j] * f[j];
    s[j] *= keep;
  }
  return alpha;
}

}  // namespace binnacle::internal::filter
