// SPDX-License-Identifier: Apache-2.0
#include "filter/definite.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::internal::filter {

// C = L D Lᵀ of the correlations C, row by row, as far as it goes: D_j is the share. Where nothing is left of a component, so
// must be of its covariances: an entry c beside a zero on the diagonal and at most a one is of an eigenvalue of −c² or less.
VarianceLeft indefinite_row(ConstMatrixView P, double* factor) {
  const int n = P.rows;
  const MatrixView L{factor, n, n, n};  // scaled by √D, but for the diagonal, which is D
  for (int i = 0; i < n; ++i) {
    double left = P(i, i) > 0 ? 1 : 0;
    for (int j = 0; j < i; ++j) {
      const double scale = std::sqrt(P(i, i)) * std::sqrt(P(j, j));
      if (scale == 0 && P(i, j) != 0) return {i, -1};
      double c = scale == 0 ? 0 : P(i, j) / scale;
      for (int k = 0; k < j; ++k) c -= L(i, k) * L(j, k);
      if (!(L(j, j) > definite_within)) {
        if (!(c * c <= definite_within)) return {i, std::max(-1 / definite_within, -c * c)};
        c = 0;
      } else {
        c /= std::sqrt(L(j, j));
      }
      L(i, j) = c;
      left -= c * c;
    }
    if (!(left >= -definite_within)) return {i, left};
    L(i, i) = left;
  }
  return {};
}

}  // namespace binnacle::internal::filter
