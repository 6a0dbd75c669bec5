// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "allan/allan.hpp"

namespace binnacle::allan {

namespace {

std::size_t as_size(std::int64_t i) { return static_cast<std::size_t>(i); }

}  // namespace

/// Averages as long as any record: 2⁴⁰ intervals.
Variances::Variances(double interval, std::int64_t full)
    : interval_(interval), full_(std::max<std::int64_t>(full, 32)) {
  constexpr int octaves = 40;
  for (int k = 0; k < octaves; ++k) {
    const std::int64_t m = std::int64_t{1} << k;
    add_factor(m);
    if (k > 0) add_factor(m + m / 2);
  }
}

void Variances::add_factor(std::int64_t m) {
  std::int64_t stride = 1;
  while (m > full_ && 32 * stride <= m && m % (2 * stride) == 0) stride *= 2;
  auto level = std::ranges::find(levels_, stride, &Level::stride);
  if (level == levels_.end()) level = levels_.insert(levels_.end(), Level{stride, {}, 0, {}});
  level->factors.push_back({m, m / stride});
  level->ring.resize(std::max(level->ring.size(), as_size(2 * (m / stride) + 1)));
}

void Variances::interrupt() {
  for (Level& level : levels_) level.size = 0;
  segment_ = 0;
  integral_ = 0;
}

void Variances::add(double mean) {
  if (count_ == 0) first_ = mean;  // a constant changes nothing but the rounding
  if (segment_ == 0)
    for (Level& level : levels_) take(level, integral_);
  ++count_;
  ++segment_;
  integral_ += interval_ * (mean - first_);
  // Strides are powers of 2 and ascend.
  for (Level& level : levels_) {
    if (segment_ % level.stride != 0) break;
    take(level, integral_);
  }
}

void Variances::take(Level& level, double integral) {
  const auto ring = static_cast<std::int64_t>(level.ring.size());
  level.ring[as_size(level.size % ring)] = integral;
  for (Factor& factor : level.factors) {
    if (level.size < 2 * factor.steps) continue;
    const double middle = level.ring[as_size((level.size - factor.steps) % ring)];
    const double first = level.ring[as_size((level.size - 2 * factor.steps) % ring)];
    const double difference = (integral - middle) - (middle - first);
    factor.sum += static_cast<long double>(difference) * difference;
    ++factor.count;
  }
  ++level.size;
}

std::vector<Point> Variances::points() const {
  std::vector<Point> all;
  for (const Level& level : levels_)
    for (const Factor& factor : level.factors) {
      if (factor.count == 0) continue;
      const double tau = static_cast<double>(factor.m) * interval_;
      const auto mean = static_cast<double>(factor.sum / static_cast<long double>(factor.count));
      all.push_back(
          {tau, mean / (2 * tau * tau), factor.count, static_cast<double>(factor.count * level.stride) * interval_});
    }
  std::ranges::sort(all, {}, &Point::tau);
  return all;
}

}  // namespace binnacle::allan
