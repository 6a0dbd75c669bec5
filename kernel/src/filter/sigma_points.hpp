// SPDX-License-Identifier: Apache-2.0
// Sigma points of a covariance, and what a function of them says: its mean, its statistical linear regression, and what
// the regression leaves. Knows no block and no model.
#pragma once

#include <vector>

#include "binnacle/view.hpp"

namespace binnacle::internal::filter {

/// With P = L Lᵀ, L lower triangular with r non-zero columns l_k: the points 0 and ±s l_k (Julier and Uhlmann, Unscented
/// filtering and nonlinear estimation, 2004) with
///
///     w_0 = max(0, 1 − r/3),   w = (1 − w_0)/(2 r),   s² = r/(1 − w_0),
///
/// so that Σ w_i ξ_i ξ_iᵀ = P. κ = 3 − r as there, but no weight is negative, so what is made of them is a covariance.
/// P may be singular: a pivot that is zero to rounding against its own diagonal has no points. Sized once: nothing else
/// allocates.
class SigmaPoints {
 public:
  /// For P of up to `most_n` rows and functions of up to `most_rows`.
  SigmaPoints(int most_n, int most_rows);

  /// Of P, of which the lower triangle is read; all finite.
  void factor(ConstMatrixView P);

  int rank() const { return static_cast<int>(pivots_.size()); }
  /// Point 0 is the centre, 1 + 2 k and 2 + 2 k are +s l_k and −s l_k.
  int count() const { return 1 + 2 * rank(); }
  double weight(int point) const { return point == 0 ? centre_weight_ : weight_; }
  /// ξ of a point: n.
  void offset(int point, VectorView xi) const;
  /// The least pivot over its diagonal; below zero by more than rounding where P is no covariance. Such a pivot has no
  /// points. 1 where P has no diagonal element above zero.
  double least_pivot() const { return least_pivot_; }

  /// Where the results of regress() go; all of it is written.
  struct Regression {
    VectorView mean;   // ē = Σ w_i e_i, m
    MatrixView M;      // m×n
    MatrixView Omega;  // Ω, m×m, symmetric to the bit; null: not wanted
  };
  /// Of e(ξ), m×count(), one column for each point; column 0 is not read where its weight is zero. M is the matrix for which
  /// e ≈ ē + M ξ is best over the points (statistical linear regression; Lefebvre, Bruyninckx and De Schutter, 2002):
  ///
  ///     M L = E,   E_k = (e_{+k} − e_{−k})/(2 s),   so M P Mᵀ = E Eᵀ
  ///     Ω = Σ w_i (e_i − ē)(e_i − ē)ᵀ − M P Mᵀ
  ///       = w_0 (e_0 − ē)(e_0 − ē)ᵀ + Σ_k 2 w m_k m_kᵀ ≥ 0,   m_k = (e_{+k} + e_{−k})/2 − ē.
  ///
  /// The points say nothing about a column of M without pivot: it is that of `fallback` (m×n), zero where that is null.
  void regress(ConstMatrixView e, ConstMatrixView fallback, const Regression& out);

 private:
  double* column(int k) { return L_.data() + static_cast<long>(k) * most_n_; }
  const double* column(int k) const { return L_.data() + static_cast<long>(k) * most_n_; }

  int most_n_;
  int n_ = 0;
  std::vector<double> L_;     // most_n × rank: the columns that are not zero
  std::vector<int> pivots_;   // the row of each one's diagonal element, ascending
  std::vector<double> loss_;  // √(P_kk / pivot_k)
  double centre_weight_ = 1, weight_ = 0, spread_ = 0, least_pivot_ = 1;
  std::vector<double> middle_;  // m_k
};

}  // namespace binnacle::internal::filter
