// SPDX-License-Identifier: Apache-2.0
#include "update_figures.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::report {

void UpdateFigures::add(double t, Outcome outcome, const std::string& reason, double nis, std::int32_t rows) {
  ++samples_;
  ++counts_[static_cast<std::size_t>(outcome)];
  outcome_ = outcome;
  if (!reason.empty()) ++reasons_[{static_cast<int>(outcome), reason}];
  if (!std::isfinite(nis) || rows <= 0) return;
  ++with_nis_;
  auto bounds = bounds_.find(rows);
  if (bounds == bounds_.end()) bounds = bounds_.emplace(rows, chi_squared_95(rows)).first;
  if (outcome != Outcome::accepted) return;
  const auto [low, high] = bounds->second;
  ++accepted_;
  accepted_rows_ += static_cast<std::size_t>(rows);
  nis_sum_ += nis;
  inside_ += nis >= low && nis <= high;
  moving_.add(t, nis);
}

void UpdateFigures::add_row(std::int32_t group, std::int64_t key, double residual, double sigma, double noise) {
  Row& row = rows_[{group, key}];
  row.least_noise = row.n == 0 ? noise : std::min(row.least_noise, noise);
  row.greatest_noise = row.n == 0 ? noise : std::max(row.greatest_noise, noise);
  ++row.n;
  if (outcome_ == Outcome::accepted) row.within.add(residual, sigma);
}

UpdateFigures figures_of(const results::Updates& updates) {
  UpdateFigures figures;
  std::size_t row = 0;
  for (std::size_t i = 0; i < updates.t.size(); ++i) {
    figures.add(updates.t[i], updates.outcome[i], i < updates.reason.size() ? updates.reason[i] : "", updates.nis[i],
                updates.rows[i]);
    for (std::int32_t r = 0; r < updates.rows[i]; ++r, ++row)
      figures.add_row(updates.group[row], updates.key[row], updates.residual[row], updates.sigma[row],
                      updates.noise[row]);
  }
  return figures;
}

}  // namespace binnacle::report
