// SPDX-License-Identifier: Apache-2.0
#include "consistency.hpp"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/chi_squared.hpp>

namespace binnacle::report {

namespace {

double quantile(double dof, double probability) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

/// Enough of them that a mean says more than its noise, and so that a plot still shows how it moves.
std::size_t mean_over(std::size_t n) { return std::clamp<std::size_t>(n / 60, 10, 200); }

}  // namespace

Within within_sigma(std::span<const double> errors, std::span<const double> sigma) {
  Within within;
  for (std::size_t i = 0; i < std::min(errors.size(), sigma.size()); ++i) {
    const double ratio = std::abs(errors[i]) / sigma[i];
    if (!(sigma[i] > 0) || std::isnan(ratio)) continue;
    ++within.of;
    within.one += ratio <= 1;
    within.two += ratio <= 2;
    within.three += ratio <= 3;
  }
  return within;
}

std::pair<double, double> chi_squared_95(double dof) {
  if (!(dof > 0)) return {0, 0};
  return {quantile(dof, 0.025), quantile(dof, 0.975)};
}

std::pair<double, double> mean_chi_squared_99(double dof, double n) {
  if (!(dof > 0) || !(n > 0)) return {0, 0};
  return {quantile(dof * n, 0.005) / n, quantile(dof * n, 0.995) / n};
}

MovingMean moving_mean(std::span<const double> t, std::span<const double> values, double mean_dof) {
  MovingMean moving;
  const std::size_t count = mean_over(values.size());
  if (values.size() < 2 * count) return moving;
  for (std::size_t begin = 0; begin + count <= values.size(); begin += count) {
    double sum = 0;
    for (std::size_t i = begin; i < begin + count; ++i) sum += values[i];
    moving.t.push_back((t[begin] + t[begin + count - 1]) / 2);
    moving.mean.push_back(sum / static_cast<double>(count));
  }
  if (mean_dof > 0) {
    const double n = static_cast<double>(count);
    moving.low = quantile(mean_dof * n, 0.025) / n;
    moving.high = quantile(mean_dof * n, 0.975) / n;
  }
  return moving;
}

}  // namespace binnacle::report
