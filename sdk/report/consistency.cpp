// SPDX-License-Identifier: Apache-2.0
#include "consistency.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "chi_squared/chi_squared.hpp"

namespace binnacle::report {

namespace {

/// Enough of them that a mean says more than its noise, and so that a plot still shows how it moves.
constexpr std::size_t longest_mean = 200;
std::size_t mean_over(std::size_t n) { return std::clamp<std::size_t>(n / 60, 10, longest_mean); }

/// Of single values, then of sums: a multiple of what any mean is over, and enough of them for the longest.
constexpr std::size_t most_stretches = 64 * longest_mean;

}  // namespace

void Within::add(double error, double sigma) {
  const double ratio = std::abs(error) / sigma;
  if (!(sigma > 0) || std::isnan(ratio)) return;
  ++of;
  one += ratio <= 1;
  two += ratio <= 2;
  three += ratio <= 3;
}

void Within::add(const Within& other) {
  of += other.of;
  one += other.one;
  two += other.two;
  three += other.three;
}

Within within_sigma(std::span<const double> errors, std::span<const double> sigma) {
  Within within;
  for (std::size_t i = 0; i < std::min(errors.size(), sigma.size()); ++i) within.add(errors[i], sigma[i]);
  return within;
}

std::pair<double, double> chi_squared_95(double dof) {
  if (!(dof > 0)) return {0, 0};
  return chi_squared_band(dof, 1, 0.95);
}

std::pair<double, double> mean_chi_squared_99(double dof, double n) {
  if (!(dof > 0) || !(n > 0)) return {0, 0};
  return chi_squared_band(dof, n, 0.99);
}

void MovingSums::append(std::vector<Stretch>& stretches, const Stretch& value, std::size_t each) {
  if (stretches.empty() || stretches.back().n >= each) {
    stretches.push_back(value);
    return;
  }
  Stretch& open = stretches.back();
  open.last = value.last;
  open.sum += value.sum;
  open.n += value.n;
}

void MovingSums::add(double t, double value) {
  ++n_;
  append(stretches_, {t, t, value, 1}, each_);
  if (stretches_.size() < most_stretches || stretches_.back().n < each_) return;
  const std::size_t each = std::max(longest_mean, 2 * each_);
  std::vector<Stretch> longer;
  for (const auto& stretch : stretches_) append(longer, stretch, each);
  stretches_ = std::move(longer);
  each_ = each;
}

MovingMean MovingSums::mean(double mean_dof) const {
  MovingMean moving;
  const std::size_t count = std::max(mean_over(n_), each_);
  if (n_ < 2 * count) return moving;
  std::vector<Stretch> means;
  for (const auto& stretch : stretches_) append(means, stretch, count);
  for (const auto& stretch : means) {
    if (stretch.n < count) break;
    moving.t.push_back((stretch.first + stretch.last) / 2);
    moving.mean.push_back(stretch.sum / static_cast<double>(count));
  }
  if (mean_dof > 0) {
    const double n = static_cast<double>(count);
    std::tie(moving.low, moving.high) = chi_squared_band(mean_dof, n, 0.95);
  }
  return moving;
}

MovingMean moving_mean(std::span<const double> t, std::span<const double> values, double mean_dof) {
  MovingSums sums;
  for (std::size_t i = 0; i < values.size(); ++i) sums.add(t[i], values[i]);
  return sums.mean(mean_dof);
}

}  // namespace binnacle::report
