// SPDX-License-Identifier: Apache-2.0
// RestWindow: is the IMU at rest, and what does it measure on average while it is?
#include "rest_window.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::coarse_alignment {

namespace {

constexpr double standard_gravity = 9.80665;

double length(const double* v) { return std::hypot(v[0], v[1], v[2]); }

}  // namespace

void RestWindow::clear() { *this = RestWindow(); }

RestWindow::Event RestWindow::add(const RestLimits& limits, double dt, const Eigen::Vector3d& rate,
                                  const Eigen::Vector3d& specific_force, RestFindings& findings) {
  time_ += dt;
  for (std::size_t i = 0; i < axes; ++i) {
    const auto axis = static_cast<Eigen::Index>(i % 3);
    const double value = i < 3 ? rate[axis] : specific_force[axis];
    sum_[i] += value * dt;
    sum_of_squares_[i] += value * value * dt;
  }
  if (time_ < limits.duration / blocks - 0.5 * dt) return Event::none;

  Means mean, variance;
  for (std::size_t i = 0; i < axes; ++i) {
    mean[i] = sum_[i] / time_;
    variance[i] = std::max(0.0, sum_of_squares_[i] / time_ - mean[i] * mean[i]);
  }
  time_ = 0;
  sum_ = sum_of_squares_ = {};
  if (!is_quiet(limits, mean, variance, findings)) {
    clear();
    return Event::disturbed;
  }
  if (count_ < 0 || count_ > capacity) count_ = 0;  // of a forged snapshot
  if (!is_like_the_others(limits, mean)) count_ = 0;
  if (count_ == capacity) {
    std::move(block_.begin() + 1, block_.end(), block_.begin());
    --count_;
  }
  block_[static_cast<std::size_t>(count_++)] = mean;
  return count_ == capacity ? Event::at_rest : Event::none;
}

void RestFindings::see(const RestLimits& limits, const std::array<double, criteria>& values,
                       double new_specific_force) {
  const auto allowed = limits_of(limits);
  for (std::size_t i = 0; i < criteria; ++i) {
    if (!(values[i] > allowed[i])) continue;
    least[i] = failed[i] == 0 ? values[i] : std::min(least[i], values[i]);
    ++failed[i];
  }
  ++stretches;
  specific_force = new_specific_force;
}

bool RestWindow::is_quiet(const RestLimits& limits, const Means& mean, const Means& variance, RestFindings& findings) {
  const auto worst = [&](std::size_t from) {
    return std::sqrt(std::max({variance[from], variance[from + 1], variance[from + 2]}));
  };
  const double specific_force = length(mean.data() + 3);
  const std::array<double, RestFindings::criteria> values{worst(3), worst(0), length(mean.data()),
                                                          std::abs(specific_force - standard_gravity)};
  findings.see(limits, values, specific_force);
  const auto allowed = RestFindings::limits_of(limits);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i] > allowed[i]) return false;
  return true;
}

bool RestWindow::is_like_the_others(const RestLimits& limits, const Means& mean) const {
  if (count_ == 0) return true;
  const Means others = mean_of_the_oldest(count_);
  for (std::size_t i = 0; i < axes; ++i)
    if (std::abs(mean[i] - others[i]) > (i < 3 ? limits.rate_sd : limits.specific_force_sd)) return false;
  return true;
}

RestWindow::Means RestWindow::mean_of_the_oldest(std::int64_t number) const {
  Means mean{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(number); ++k)
    for (std::size_t i = 0; i < axes; ++i) mean[i] += block_[k][i] / static_cast<double>(number);
  return mean;
}

RestMeans RestWindow::means() const {
  // The variance of a mean estimated from n parts is used in place of the true one: E[1/s²] = (n−1)/(n−3) / σ².
  constexpr double n = blocks;
  constexpr double factor = 1.0 / (n * (n - 1)) * (n - 1) / (n - 3);
  const Means mean = mean_of_the_oldest(blocks);
  RestMeans result;
  for (std::size_t i = 0; i < axes; ++i) {
    double squares = 0;
    for (std::size_t k = 0; k < blocks; ++k) squares += (block_[k][i] - mean[i]) * (block_[k][i] - mean[i]);
    double& variance = i < 3 ? result.rate_variance : result.specific_force_variance;
    variance = std::max(variance, squares * factor);
    (i < 3 ? result.rate : result.specific_force)[static_cast<Eigen::Index>(i % 3)] = mean[i];
  }
  return result;
}

}  // namespace binnacle::coarse_alignment
