// SPDX-License-Identifier: Apache-2.0
#include "thinned_updates.hpp"

#include <algorithm>
#include <cmath>

#include "binnacle/time.hpp"
#include "decimation.hpp"
#include "missing.hpp"

namespace binnacle::report {

namespace {

/// Rows of a sample whose extremes are kept besides those of its NIS.
constexpr std::size_t most_slots = 4;

std::vector<std::vector<double>> residuals_by_slot(const results::Updates& updates) {
  std::vector<std::vector<double>> slots(most_slots, std::vector<double>(updates.t.size(), not_a_number));
  std::size_t row = 0;
  for (std::size_t i = 0; i < updates.t.size(); ++i) {
    const auto rows = static_cast<std::size_t>(updates.rows[i]);
    for (std::size_t slot = 0; slot < std::min(rows, most_slots); ++slot) slots[slot][i] = updates.residual[row + slot];
    row += rows;
  }
  return slots;
}

template <class T>
void pick(std::vector<T>& values, const std::vector<std::size_t>& indices) {
  for (std::size_t i = 0; i < indices.size(); ++i)
    values[i] = values[indices[i]];  // ascending: none is overwritten early
  values.resize(indices.size());
}

}  // namespace

ThinnedUpdates::ThinnedUpdates(const MeasurementInfo& info, std::size_t samples, std::size_t rows)
    : sample_limit_(samples),
      row_limit_(std::max<std::size_t>(rows, 64 * static_cast<std::size_t>(std::max(0, info.max_rows)))) {
  updates_.measurement = info.name;
  for (const auto& group : info.groups) updates_.groups.push_back({group.name, group.unit});
}

void ThinnedUpdates::add(const UpdateRecord& record) {
  const bool is_linearized = record.residual != nullptr;
  updates_.t.push_back(results::nearest_seconds(record.t));
  updates_.outcome.push_back(record.outcome);
  updates_.nis.push_back(is_linearized ? record.nis : not_a_number);
  updates_.rows.push_back(is_linearized ? record.rows : 0);
  for (int row = 0; row < updates_.rows.back(); ++row) {
    updates_.group.push_back(record.row_groups[row]);
    updates_.key.push_back(record.row_keys[row]);
    updates_.residual.push_back(record.residual[row]);
    updates_.sigma.push_back(std::sqrt(record.S(row, row)));
    updates_.noise.push_back(std::sqrt(record.R(row, row)));
  }
  if (is_full()) thin();
}

void ThinnedUpdates::rewind(double t) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < updates_.t.size(); ++i)
    if (updates_.t[i] <= t) kept.push_back(i);
  if (kept.size() < updates_.t.size()) keep(kept);
}

bool ThinnedUpdates::is_full() const { return updates_.t.size() >= sample_limit_ || updates_.key.size() >= row_limit_; }

/// To less than half of what there may be, so that it is seldom done; in longer stretches only where that must be.
void ThinnedUpdates::thin() {
  const auto [first, last] = std::minmax_element(updates_.t.begin(), updates_.t.end());
  const double span = *last - *first;
  if (width_ == 0) width_ = std::max(span / static_cast<double>(sample_limit_), 1e-9);
  const auto slots = residuals_by_slot(updates_);
  std::vector<Series> series{updates_.nis};
  for (const auto& slot : slots) series.emplace_back(slot);
  std::vector<std::uint8_t> kinds;
  for (const auto outcome : updates_.outcome) kinds.push_back(static_cast<std::uint8_t>(outcome));
  const auto is_much = [&](const std::vector<std::size_t>& samples) {
    std::size_t rows = 0;
    for (const auto i : samples) rows += static_cast<std::size_t>(updates_.rows[i]);
    return samples.size() > sample_limit_ / 2 || rows > row_limit_ / 2;
  };
  auto kept = extremes_in_time(series, kinds, updates_.t, width_);
  while (is_much(kept) && width_ < 2 * span) {
    width_ *= 2;
    kept = extremes_in_time(series, kinds, updates_.t, width_);
  }
  keep(kept);
}

void ThinnedUpdates::keep(const std::vector<std::size_t>& samples) {
  std::vector<std::size_t> begins{0}, rows;
  for (const auto count : updates_.rows) begins.push_back(begins.back() + static_cast<std::size_t>(count));
  for (const auto i : samples)
    for (std::size_t row = begins[i]; row < begins[i + 1]; ++row) rows.push_back(row);
  pick(updates_.t, samples);
  pick(updates_.outcome, samples);
  pick(updates_.nis, samples);
  pick(updates_.rows, samples);
  pick(updates_.group, rows);
  pick(updates_.key, rows);
  pick(updates_.residual, rows);
  pick(updates_.sigma, rows);
  pick(updates_.noise, rows);
}

}  // namespace binnacle::report
