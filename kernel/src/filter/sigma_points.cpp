// SPDX-License-Identifier: Apache-2.0
#include "filter/sigma_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/index.hpp"
#include "binnacle/eigen.hpp"

namespace binnacle::internal::filter {

using base::as_size;

namespace {

/// Omega += weight v vᵀ, lower triangle.
void add_outer(double weight, const std::vector<double>& v, MatrixView Omega) {
  for (int j = 0; j < Omega.cols; ++j)
    for (int i = j; i < Omega.rows; ++i) Omega(i, j) += weight * v[as_size(i)] * v[as_size(j)];
}

}  // namespace

SigmaPoints::SigmaPoints(int most_n, int most_rows)
    : most_n_(most_n), L_(as_size(most_n) * as_size(most_n)), loss_(as_size(most_n)), middle_(as_size(most_rows)) {
  pivots_.reserve(as_size(most_n));
}

/// Column by column, without pivoting: of a covariance, what stands below a pivot of zero is zero. A pivot is known to the
/// rounding of its diagonal and of what is subtracted: an element l_jk has that of √(P_jj P_kk) over √pivot_k.
void SigmaPoints::factor(ConstMatrixView P) {
  n_ = P.rows;
  pivots_.clear();
  least_pivot_ = 1;
  const double rounding = 4 * n_ * std::numeric_limits<double>::epsilon();
  for (int j = 0; j < n_; ++j) {
    const double diagonal = P(j, j);
    double pivot = diagonal, unknown = std::sqrt(diagonal);
    for (int k = 0; k < rank(); ++k) {
      const double l = column(k)[j];
      pivot -= l * l;
      unknown += 2 * std::abs(l) * loss_[as_size(k)];
    }
    if (diagonal > 0) least_pivot_ = std::min(least_pivot_, pivot / diagonal);
    if (!(pivot > rounding * std::sqrt(diagonal) * unknown)) continue;
    loss_[as_size(rank())] = std::sqrt(diagonal / pivot);
    double* const own = column(rank());
    std::fill_n(own, j, 0.0);
    for (int i = j; i < n_; ++i) own[i] = P(i, j);
    for (int k = 0; k < rank(); ++k) {
      const double* const l = column(k);
      const double factor = l[j];
      if (factor == 0) continue;
      for (int i = j + 1; i < n_; ++i) own[i] -= factor * l[i];
    }
    own[j] = std::sqrt(pivot);
    for (int i = j + 1; i < n_; ++i) own[i] /= own[j];
    pivots_.push_back(j);
  }
  const double r = rank();
  centre_weight_ = std::max(0.0, 1 - r / 3);
  weight_ = rank() > 0 ? (1 - centre_weight_) / (2 * r) : 0;
  spread_ = rank() > 0 ? std::sqrt(r / (1 - centre_weight_)) : 0;
}

void SigmaPoints::offset(int point, VectorView xi) const {
  if (point == 0) {
    std::fill_n(xi.data(), n_, 0.0);
    return;
  }
  const double* const l = column((point - 1) / 2);
  const double by = point % 2 == 1 ? spread_ : -spread_;
  for (int i = 0; i < n_; ++i) xi[i] = by * l[i];
}

void SigmaPoints::regress(ConstMatrixView e, ConstMatrixView fallback, const Regression& out) {
  const int m = e.rows;
  for (int i = 0; i < m; ++i) out.mean[i] = centre_weight_ > 0 ? centre_weight_ * e(i, 0) : 0;
  for (int k = 0; k < rank(); ++k)
    for (int i = 0; i < m; ++i) out.mean[i] += weight_ * (e(i, 1 + 2 * k) + e(i, 2 + 2 * k));

  if (out.Omega) {
    out.Omega.as().setZero();
    if (centre_weight_ > 0) {
      for (int i = 0; i < m; ++i) middle_[as_size(i)] = e(i, 0) - out.mean[i];
      add_outer(centre_weight_, middle_, out.Omega);
    }
    for (int k = 0; k < rank(); ++k) {
      for (int i = 0; i < m; ++i) middle_[as_size(i)] = 0.5 * (e(i, 1 + 2 * k) + e(i, 2 + 2 * k)) - out.mean[i];
      add_outer(2 * weight_, middle_, out.Omega);
    }
    for (int j = 0; j < m; ++j)
      for (int i = 0; i < j; ++i) out.Omega(i, j) = out.Omega(j, i);
  }

  // From the last column to the first: M_p l_pp = E_k − Σ_{i>p} M_i l_ip.
  int k = rank() - 1;
  for (int p = n_ - 1; p >= 0; --p) {
    if (k < 0 || pivots_[as_size(k)] != p) {
      for (int i = 0; i < m; ++i) out.M(i, p) = fallback ? fallback(i, p) : 0;
      continue;
    }
    const double* const l = column(k);
    for (int i = 0; i < m; ++i) out.M(i, p) = (e(i, 1 + 2 * k) - e(i, 2 + 2 * k)) / (2 * spread_);
    for (int c = p + 1; c < n_; ++c) {
      if (l[c] == 0) continue;
      for (int i = 0; i < m; ++i) out.M(i, p) -= out.M(i, c) * l[c];
    }
    for (int i = 0; i < m; ++i) out.M(i, p) /= l[p];
    --k;
  }
}

}  // namespace binnacle::internal::filter
