// SPDX-License-Identifier: Apache-2.0
#include "jump_watch.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::score {

namespace {

constexpr double far_beyond = 10 * 3;  // σ

}  // namespace

JumpWatch::JumpWatch(const FilterInfo& filter)
    : filter_(filter), variances_(filter.blocks.size()), largest_(filter.measurements.size() * filter.blocks.size()) {}

void JumpWatch::inflated(const InflationRecord& record) {
  if (!record.P0 || (record.t == opened_at_ && record.measurement == opened_by_)) return;
  opened_at_ = record.t;
  opened_by_ = record.measurement;
  for (std::size_t b = 0; b < variances_.size(); ++b) {
    const auto& block = filter_.blocks[b];
    variances_[b] = 0;
    for (int row = block.first_row; row < block.first_row + static_cast<int>(block.active.size()); ++row)
      variances_[b] += record.P0(row, row);
  }
}

void JumpWatch::offered(const UpdateRecord& record) {
  if (record.outcome == Outcome::gated || record.left_out > 0)
    refusing_ = record.measurement;
  else if (record.measurement == refusing_)
    refusing_ = -1;
  if (!record.delta || record.t != opened_at_ || record.measurement != opened_by_) return;
  for (std::size_t b = 0; b < variances_.size(); ++b) {
    const auto& block = filter_.blocks[b];
    const auto* const first = record.delta + block.first_row;
    double square = 0;
    for (std::size_t i = 0; i < block.active.size(); ++i) square += first[i] * first[i];
    double& largest = largest_[place(record.measurement, static_cast<int>(b))];
    if (square > far_beyond * far_beyond * variances_[b]) largest = std::max(largest, std::sqrt(square));
  }
}

void JumpWatch::exchange(StateBytes& bytes) {
  bytes.value(refusing_);
  bytes.value(opened_by_);
  bytes.value(opened_at_);
  for (auto* numbers : {&variances_, &largest_})
    for (double& number : *numbers) bytes.value(number);
}

}  // namespace binnacle::score
