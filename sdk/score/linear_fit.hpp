// SPDX-License-Identifier: Apache-2.0
// Least squares of one figure over several, from sums alone.
#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <limits>

#include "algebra/decompositions.hpp"

namespace binnacle::score {

/// A coefficient this many 1-sigmas off is no matter of noise.
inline constexpr double clear_sigmas = 5;

/// y = coefficients · x + noise, over `count` rows.
template <int N>
struct LinearFit {
  Eigen::Matrix<double, N, 1> coefficients = Eigen::Matrix<double, N, 1>::Zero();
  Eigen::Matrix<double, N, N> covariance = Eigen::Matrix<double, N, N>::Zero();  // of the coefficients
  double squares = std::numeric_limits<double>::infinity();                      // that are left
  double explained = 0;                                                          // share of yy
  bool is_determined = false;
};

/// XtX = Σ x xᵀ, Xty = Σ x y, yy = Σ y².
template <int N>
LinearFit<N> fit(const Eigen::Matrix<double, N, N>& XtX, const Eigen::Matrix<double, N, 1>& Xty, double yy,
                 double count) {
  LinearFit<N> fit;
  const Eigen::Matrix<double, N, 1> scale = XtX.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::Matrix<double, N, N> scaled = scale.asDiagonal() * XtX * scale.asDiagonal();
  const algebra::Cholesky factor(scaled);
  if (count <= N || !(yy > 0) || !factor.is_positive() || factor.rcond() < 1e-9) return fit;
  const Eigen::Matrix<double, N, N> unscaled = factor.solve(Eigen::MatrixXd::Identity(N, N));
  const Eigen::Matrix<double, N, N> inverse = scale.asDiagonal() * unscaled * scale.asDiagonal();
  fit.coefficients = inverse * Xty;
  fit.squares = std::max(yy - fit.coefficients.dot(Xty), 1e-12 * yy);
  fit.covariance = inverse * (fit.squares / (count - N));
  fit.explained = 1 - fit.squares / yy;
  fit.is_determined = true;
  return fit;
}

}  // namespace binnacle::score
