// SPDX-License-Identifier: Apache-2.0
#include "statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "algebra/decompositions.hpp"

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

namespace {

/// Where the tail of sorted values, as a power law through two of its quantiles, would be exceeded once in 10^4 records.
/// Between 90 and 99 % of few values, between 99 and 99.9 % of many; a tail is never taken to be thinner than a fourth power.
double beyond_tail(const std::vector<double>& sorted) {
  const double n = static_cast<double>(sorted.size()), share = n > 20'000 ? 0.01 : 0.1;
  const auto at = [&](double upper) { return sorted[static_cast<std::size_t>((1 - upper) * (n - 1))]; };
  const double low = at(share), high = at(0.1 * share);
  if (!(low > 0)) return 0;
  const double exponent = std::max(0.25, std::log10(high / low));
  return high * std::pow(0.1 * share * n / 1e-4, exponent);
}

}  // namespace

std::vector<std::size_t> spikes(const std::vector<double>& x, double& limit) {
  std::vector<std::size_t> rows;
  if (x.size() < 100) return rows;
  std::vector<double> away(x.size(), 0);
  for (std::size_t i = 1; i + 1 < x.size(); ++i) {
    const double up = x[i] - x[i - 1], down = x[i] - x[i + 1];
    if (up * down > 0) away[i] = std::min(std::abs(up), std::abs(down));
  }
  std::vector<double> sorted = away;
  std::ranges::sort(sorted);
  limit = beyond_tail(sorted);
  if (!(limit > 0)) return rows;
  for (std::size_t i = 0; i < away.size(); ++i)
    if (away[i] > limit) rows.push_back(i);
  std::ranges::stable_sort(rows, {}, [&](std::size_t i) { return -away[i]; });
  return rows;
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

double biweight(double residual, double sigma) {
  const double z = residual / (4.685 * sigma);
  return std::abs(z) < 1 ? (1 - z * z) * (1 - z * z) : 0;
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
    fit.beta = algebra::PivotedCholesky(normal).solve_vector(X.transpose() * weight.asDiagonal() * y);
    residual = y - X * fit.beta;
    std::vector<double> size(static_cast<std::size_t>(n));
    for (Eigen::Index i = 0; i < n; ++i) size[static_cast<std::size_t>(i)] = std::abs(residual[i]);
    fit.sigma = std::max(1.4826 * median(std::move(size)), 1e-300);
    for (Eigen::Index i = 0; i < n; ++i) weight[i] = biweight(residual[i], fit.sigma);
  }
  const double total = weight.sum();
  const double mean = weight.dot(y) / total;
  const double about_mean = weight.dot((y.array() - mean).square().matrix());
  const double left = weight.dot(residual.cwiseAbs2());
  fit.explained = about_mean > 0 ? 1 - left / about_mean : 0;
  fit.standard_error =
      (algebra::PivotedCholesky(normal).solve(Eigen::MatrixXd::Identity(p, p)).diagonal() * (left / total))
          .cwiseMax(0)
          .cwiseSqrt();
  fit.used = static_cast<std::size_t>(n);
  return fit;
}

}  // namespace binnacle::inspect
