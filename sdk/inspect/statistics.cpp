// SPDX-License-Identifier: Apache-2.0
#include "statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace binnacle::inspect {

double quantile(std::vector<double> values, double p) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(p * static_cast<double>(values.size() - 1) + 0.5);
  std::ranges::nth_element(values, at);
  return *at;
}

double median(std::vector<double> values) { return quantile(std::move(values), 0.5); }

double robust_sigma(const std::vector<double>& values) {
  const double centre = median(values);
  std::vector<double> distance;
  distance.reserve(values.size());
  for (const double value : values) distance.push_back(std::abs(value - centre));
  return 1.4826 * median(std::move(distance));
}

double student_tail(double t, std::size_t dof) {
  const double theta = std::atan2(t, std::sqrt(static_cast<double>(dof)));
  const double sine = std::sin(theta), cosine2 = std::cos(theta) * std::cos(theta);
  const bool is_odd = dof % 2 == 1;
  double term = is_odd ? std::cos(theta) : 1, sum = dof == 1 ? 0 : term;
  for (std::size_t k = is_odd ? 3 : 2; k + (is_odd ? 1 : 0) < dof; k += 2) {
    term *= cosine2 * static_cast<double>(k - 1) / static_cast<double>(k);
    sum += term;
  }
  const double inside = is_odd ? 2 / 3.141592653589793 * (theta + sine * sum) : sine * sum;
  return std::max(0.0, 0.5 * (1 - inside));
}

LinearFit robust_fit(const Eigen::MatrixXd& X, const Eigen::VectorXd& y) {
  const Eigen::Index n = X.rows(), p = X.cols();
  LinearFit fit;
  fit.beta = fit.standard_error = Eigen::VectorXd::Constant(p, std::numeric_limits<double>::quiet_NaN());
  if (n < 3 * p + 5) return fit;
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(n), residual;
  Eigen::MatrixXd normal;
  for (int pass = 0; pass < 8; ++pass) {
    normal = X.transpose() * weight.asDiagonal() * X;
    fit.beta = normal.ldlt().solve(X.transpose() * weight.asDiagonal() * y);
    residual = y - X * fit.beta;
    std::vector<double> size(static_cast<std::size_t>(n));
    for (Eigen::Index i = 0; i < n; ++i) size[static_cast<std::size_t>(i)] = std::abs(residual[i]);
    fit.sigma = std::max(1.4826 * median(std::move(size)), 1e-300);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double z = residual[i] / (4.685 * fit.sigma);
      weight[i] = std::abs(z) < 1 ? (1 - z * z) * (1 - z * z) : 0;
    }
  }
  const double total = weight.sum();
  const double mean = weight.dot(y) / total;
  const double about_mean = weight.dot((y.array() - mean).square().matrix());
  const double left = weight.dot(residual.cwiseAbs2());
  fit.explained = about_mean > 0 ? 1 - left / about_mean : 0;
  fit.standard_error =
      (normal.ldlt().solve(Eigen::MatrixXd::Identity(p, p)).diagonal() * (left / total)).cwiseMax(0).cwiseSqrt();
  fit.used = static_cast<std::size_t>(n);
  return fit;
}

}  // namespace binnacle::inspect
