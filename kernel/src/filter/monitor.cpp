// SPDX-License-Identifier: Apache-2.0
#include "filter/monitor.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::internal::filter {

// Wilson and Hilferty (1931): the cube root of χ²/d is nearly normal, about 1 − 2/(9 d) and of variance 2/(9 d).
double normal_score(double ratio, double d) { return (std::cbrt(ratio) - 1 + 2 / (9 * d)) / std::sqrt(2 / (9 * d)); }

double ratio_of(double score, double d) { return std::pow(1 - 2 / (9 * d) + score * std::sqrt(2 / (9 * d)), 3); }

void RowMonitor::use(Time t, double r, double its_R, double S) {
  const double now = r / std::sqrt(S), product = used > 0 ? now * previous : 0.0;
  ++used;
  last = t;
  streak.end();
  z += now;
  zz += now * now;
  lag += product;
  rr += r * r;
  HPHt += S - its_R;
  R += its_R;
  previous = now;
  window.use(t);
  window_z += now;
  window_lag += product;
  if (!window.is_full(t)) return;
  const double n = static_cast<double>(window.count), root = std::sqrt(n);
  bias.see(std::abs(window_z) / root, window_z / n, n, window.since);
  correlation.see(window_lag / root, window_lag / n, n, window.since);
  ++windows;
  window = {};
  window_z = window_lag = 0;
}

void NisMonitor::use(Time t, double its_nis, int its_rows) {
  window.use(t);
  nis += its_nis;
  rows += its_rows;
  if (!window.is_full(t)) return;
  const double d = static_cast<double>(rows);
  newest = nis / d;
  worst.see(normal_score(newest, d), newest, d, window.since);
  ++windows;
  window = {};
  nis = 0;
  rows = 0;
}

RowMonitor* find_row(std::span<RowMonitor> table, int group, std::int64_t key, std::size_t hint) {
  const auto is_it = [&](const RowMonitor& row) { return row.is_in_use && row.group == group && row.key == key; };
  if (hint < table.size() && is_it(table[hint])) return &table[hint];
  const auto found = std::ranges::find_if(table, [&](const RowMonitor& row) { return !row.is_in_use || is_it(row); });
  if (found == table.end()) return nullptr;
  if (!found->is_in_use) {
    found->group = group;
    found->key = key;
    found->is_in_use = 1;
  }
  return &*found;
}

const RowMonitor* known_row(std::span<const RowMonitor> table, int group, std::int64_t key) {
  const auto found = std::ranges::find_if(table, [&](const RowMonitor& row) {
    return row.is_in_use && row.group == group && row.key == key;
  });
  return found == table.end() ? nullptr : &*found;
}

RowFigures figures_of(const RowMonitor& row) {
  RowFigures figures{row.group, row.key, row.used, row.left_out, row.refused};
  if (row.used == 0) return figures;
  const double n = static_cast<double>(row.used);
  figures.mean = row.z / n;
  figures.rms = std::sqrt(row.zz / n);
  figures.correlation = row.zz > 0 ? row.lag / row.zz : 0.0;
  figures.sigma = std::sqrt(std::max(0.0, row.R / n));
  figures.fitting_sigma = std::sqrt(std::max(0.0, (row.rr - row.HPHt) / n));
  return figures;
}

}  // namespace binnacle::internal::filter
