// SPDX-License-Identifier: Apache-2.0
#include "filter/monitor.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::internal::filter {

// Wilson and Hilferty (1931): the cube root of χ²/d is nearly normal, about 1 − 2/(9 d) and of variance 2/(9 d).
double normal_score(double ratio, double d) { return (std::cbrt(ratio) - 1 + 2 / (9 * d)) / std::sqrt(2 / (9 * d)); }

double ratio_of(double score, double d) { return std::pow(1 - 2 / (9 * d) + score * std::sqrt(2 / (9 * d)), 3); }

namespace {

// The sum of n products of neighbours of white noise N(0, 1), over n: y. Its cumulants' function is
//     K(t) = −n/2 ln((1 + √(1 − 4 t²))/2) ,
// and with 2 t = sin φ, u = tan(φ/2) the saddlepoint K'(t) = n y is u (1 + u²)/(1 − u²) = y. The signed root of the
// deviance there is nearly normal far into the tail (Daniels, 1954), where the sum itself is not.
double lag_of_saddlepoint(double u) { return u * (1 + u * u) / (1 - u * u); }

double score_of_saddlepoint(double u, double n) {
  const double phi = 2 * std::atan(u), t = std::sin(phi) / 2;
  return std::sqrt(std::max(0.0, 2 * (t * n * lag_of_saddlepoint(u) + n / 2 * std::log((1 + std::cos(phi)) / 2))));
}

/// The u in [0, 1) where a function that grows reaches a value.
template <class Function>
double where(Function&& function, double value) {
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (function(middle) < value ? low : high) = middle;
  }
  return low;
}

}  // namespace

double lag_score(double y, double n) { return y > 0 ? score_of_saddlepoint(where(lag_of_saddlepoint, y), n) : 0.0; }

double lag_of(double score, double n) {
  return lag_of_saddlepoint(where([&](double u) { return score_of_saddlepoint(u, n); }, score));
}

void RowMonitor::refuse(Time t, std::int64_t its_turn) {
  if (its_turn - turn > most_absent) streak.end();
  if (refused == 0) first_refused = t;
  turn = its_turn;
  streak.refuse(t, last);
  last = t;
  ++refused;
}

Extreme RowMonitor::open_bias() const {
  const double n = static_cast<double>(std::max<std::int64_t>(1, window.count));
  return {std::abs(window_z) / std::sqrt(n), window_z / n, n, window.since};
}

Extreme RowMonitor::open_correlation() const {
  constexpr std::int64_t least = 20;  // the first has no neighbour in the window
  if (window.count < least) return {};
  const double n = static_cast<double>(window.count);
  return {lag_score(window_lag / n, n), window_lag / n, n, window.since};
}

Extreme NisMonitor::open() const {
  if (rows == 0) return {};
  const double d = static_cast<double>(rows);
  return {normal_score(nis / d, d), nis / d, d, window.since};
}

Extreme RowMonitor::open_long_bias() const {
  const double n = static_cast<double>(std::max<std::int64_t>(1, used - long_used)), sum = z - long_z;
  return {std::abs(sum) / std::sqrt(n), sum / n, n, long_since};
}

namespace {

/// Of n numbers: whether their mean is what no right filter has, and worth a correction.
bool is_surely_biased(double sum, double n) {
  return std::abs(sum) > RowMonitor::surely * std::sqrt(n) && std::abs(sum) > RowMonitor::material * n;
}

}  // namespace

bool RowMonitor::use(Time t, std::int64_t its_turn, double r, double its_R, double S, Time against) {
  const double now = r / std::sqrt(S), product = used > 0 ? now * previous : 0.0;
  if (long_since == no_time) long_since = t;
  ++used;
  last = t;
  turn = its_turn;
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
  biased_z += now;
  ++biased_count;
  if (!window.is_full(t))
    return biased.count > 0 && t - biased.since >= against && is_surely_biased(biased_z, biased_count);
  bias.see(open_bias());
  correlation.see(open_correlation());
  biased_z = window_z;
  biased_count = static_cast<double>(window.count);
  const bool is_biased = is_surely_biased(biased_z, biased_count);
  if (is_biased)
    biased.refuse(window.since);
  else
    biased.end();
  ++windows;
  window = {};
  window_z = window_lag = 0;
  if (t - long_since >= long_time) {
    long_bias.see(open_long_bias());
    ++longs;
    long_since = no_time;
    long_used = used;
    long_z = z;
  }
  return is_biased;
}

void RowMonitor::see(double r, double its_R, double its_post_fit) {
  constexpr double most_power = 9, most = 6;  // one outlier is no scatter
  claim = its_R / widened;
  const double d = r - post_fit, a = d - moved;
  if (++seen > 3 && claim > 0) {
    const double n = static_cast<double>(std::min(seen, widened > 1 ? scatter_memory / 3 : scatter_memory));
    const double product = std::clamp(-a * bent / (4 * claim), -most * power, most * power);
    power += (std::min(a * a / (6 * claim), most_power * power) - power) / n;
    scatter += (product - scatter) / n;
    if (widened > 1) widest = std::max(widest, widened += std::max(scatter - widened, (1 - widened) / n));
  }
  bent = a;
  moved = d;
  post_fit = its_post_fit;
}

void RowMonitor::begin_anew() {
  window = {};
  window_z = window_lag = 0;
  long_since = no_time;
  long_used = used;
  long_z = z;
  biased.end();
}

void NisMonitor::begin_anew() {
  window = {};
  nis = 0;
  rows = 0;
}

void NisMonitor::use(Time t, double its_nis, int its_rows) {
  window.use(t);
  nis += its_nis;
  rows += its_rows;
  if (!window.is_full(t)) return;
  newest = nis / static_cast<double>(rows);
  worst.see(open());
  ++windows;
  begin_anew();
}

RowMonitor& find_row(std::span<RowMonitor> table, int group, std::int64_t key, std::size_t hint) {
  const auto is_it = [&](const RowMonitor& row) { return row.is_in_use && row.group == group && row.key == key; };
  if (hint < table.size() && is_it(table[hint])) return table[hint];
  auto found = std::ranges::find_if(table, [&](const RowMonitor& row) { return !row.is_in_use || is_it(row); });
  if (found != table.end() && found->is_in_use) return *found;
  if (found == table.end()) found = std::ranges::min_element(table, {}, &RowMonitor::last);
  *found = RowMonitor{};
  found->group = group;
  found->key = key;
  found->is_in_use = 1;
  return *found;
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
