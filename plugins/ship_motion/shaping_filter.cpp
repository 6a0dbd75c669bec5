// SPDX-License-Identifier: Apache-2.0
#include "shaping_filter.hpp"

#include <cmath>
#include <numbers>

#include "algebra/decompositions.hpp"

namespace binnacle::ship_motion {

namespace {

using std::numbers::pi;

/// F P + P Fᵀ + g gᵀ = 0 with g the last unit vector, by Kronecker products.
Eigen::MatrixXd covariance_of_unit_noise(const Eigen::MatrixXd& F) {
  const Eigen::Index n = F.rows();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n * n, n * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index k = 0; k < n; ++k) {
        A(i + n * j, k + n * j) += F(i, k);
        A(i + n * j, i + n * k) += F(j, k);
      }
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n * n);
  b[n * n - 1] = -1;
  const Eigen::VectorXd p = algebra::solve(A, b);
  return Eigen::Map<const Eigen::MatrixXd>(p.data(), n, n);
}

/// Π |ω² − ν² + 2iζων|²
double stiffness(const ShapingFilter& filter, double nu) {
  double product = 1;
  for (Eigen::Index k = 0; k < filter.omega.size(); ++k) {
    const double w = filter.omega[k];
    product *= std::pow(w * w - nu * nu, 2) + std::pow(2 * filter.zeta[k] * w * nu, 2);
  }
  return product;
}

}  // namespace

Eigen::MatrixXd ShapingFilter::dynamics() const {
  Eigen::MatrixXd F = Eigen::MatrixXd::Zero(order(), order());
  for (Eigen::Index k = 0; k < omega.size(); ++k) {
    F(2 * k, 2 * k + 1) = 1;
    F(2 * k + 1, 2 * k) = -omega[k] * omega[k];
    F(2 * k + 1, 2 * k + 1) = -2 * zeta[k] * omega[k];
    if (2 * k + 2 < order()) F(2 * k + 1, 2 * k + 2) = 1;
  }
  return F;
}

Eigen::MatrixXd ShapingFilter::steady_covariance() const {
  const Eigen::MatrixXd P = covariance_of_unit_noise(dynamics());
  return P * (sigma * sigma / P(0, 0));
}

double ShapingFilter::noise_density() const { return sigma * sigma / covariance_of_unit_noise(dynamics())(0, 0); }

Eigen::VectorXd ShapingFilter::autocovariance(double interval, Eigen::Index count) const {
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 4, 4>;
  const Square Phi = algebra::exponential(dynamics() * interval);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 4, 1> x = steady_covariance().col(0);
  Eigen::VectorXd r(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    r[k] = x[0];
    x = (Phi * x).eval();
  }
  return r;
}

Eigen::VectorXd ShapingFilter::spectrum(const Eigen::VectorXd& nu) const {
  const double power = noise_density() / pi;
  return nu.unaryExpr([&](double at) { return power / stiffness(*this, at); });
}

double ShapingFilter::peak() const {
  constexpr int steps = 2000;
  const double step = 1.2 * omega.maxCoeff() / steps;
  int at = 0;
  for (int k = 1; k <= steps; ++k)
    if (stiffness(*this, k * step) < stiffness(*this, at * step)) at = k;
  return at * step;
}

}  // namespace binnacle::ship_motion
