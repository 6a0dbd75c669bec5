// SPDX-License-Identifier: Apache-2.0
// Recovery from a lock-out: P is opened along what a refused sample sees, as far as its residual asks for.
#include <cmath>

#include <Eigen/Cholesky>

#include "filter/estimator.hpp"

namespace binnacle::internal::filter {

namespace {

/// Solves A x = b in place of A and b; false where A is not positive definite.
template <class Matrix, class Vector>
bool solve_in_place(Matrix&& A, Vector&& b) {
  Eigen::Ref<Eigen::MatrixXd> in_place(A);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(in_place);
  if (factor.info() != Eigen::Success) return false;
  factor.solveInPlace(b);
  return true;
}

}  // namespace

Opening::Opening(int n, int max_rows)
    : direction(as_size(padded(n))),
      matrix_(max_rows, max_rows),
      weights_(max_rows),
      s_(max_rows),
      whitened_(max_rows) {}

// Let r be the residual of the rows, with S = H P Hᵀ + R. Of all errors of the state that explain r,
//     g = P Hᵀ (H P Hᵀ + ε R)⁻¹ r ,  s = H g ,
// is the likeliest under P: it moves what the rows see, and through P's correlations all that goes with it. What no error
// of the state explains (a residual that contradicts itself) is left out thanks to the small part of R. With P + c g gᵀ,
// Sherman and Morrison (1950) give
//     NIS(c) = n − c a² / (1 + c b) ,  n = rᵀ S⁻¹ r, a = sᵀ S⁻¹ r, b = sᵀ S⁻¹ s ,
// and c is chosen so that NIS is `aim`, what a right sample would have. Where no c does, g itself is one sigma: c = 1.
bool Opening::find(const SampleRows& rows, int n, double aim) {
  constexpr double epsilon = 1e-4;
  const int m = rows.m;
  const auto HPHt = ConstMatrixView(rows.square(rows.HPHt)).as();
  const auto R = ConstMatrixView(rows.square(rows.R)).as();
  const auto r = ConstVectorView(rows.r, m).as();
  auto A = matrix_.topLeftCorner(m, m);
  auto weights = weights_.head(m), s = s_.head(m), whitened = whitened_.head(m);
  A = HPHt + epsilon * R;
  weights = r;
  if (!solve_in_place(A, weights)) return false;
  s.noalias() = HPHt.lazyProduct(weights);
  A = HPHt + R;
  whitened = r;
  if (!solve_in_place(A, whitened)) return false;
  const double a = s.dot(whitened), excess = r.dot(whitened) - aim;
  A = HPHt + R;
  whitened = s;
  if (!solve_in_place(A, whitened)) return false;
  const double b = s.dot(whitened);
  if (!(excess > 0 && a > 0 && b > 0)) return false;
  const double c = a * a > excess * b ? excess / (a * a - excess * b) : 1.0;
  const auto G = ConstMatrixView{rows.G, n, m, padded(n)}.as();
  Eigen::Map<Eigen::VectorXd>(direction.data(), n) = std::sqrt(c) * G.lazyProduct(weights);
  return true;
}

bool Estimator::open(double aim) {
  if (!opening_.find(rows_, plan_.n, aim)) return false;
  for (std::size_t i = 0; i < plan_.corrected.size(); ++i)
    if (!plan_.corrected[i]) opening_.direction[i] = 0;
  P_->open(opening_.direction.data());
  return true;
}

}  // namespace binnacle::internal::filter
