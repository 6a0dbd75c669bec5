// SPDX-License-Identifier: Apache-2.0
// Monitors of a measurement, kept while the filter runs: what the gate did to each row, and how innovations were
// distributed, over the whole run, over windows of at least 50 uses and 10 s, and their mean over ten minutes.
#pragma once

#include <cstdint>
#include <span>

#include "binnacle/time.hpp"
#include "binnacle/trust.hpp"
#include "binnacle/view.hpp"

namespace binnacle::internal::filter {

/// The rows of a sample that is judged; HPHt without R.
struct OfferedRows {
  std::span<const std::int64_t> keys;
  const int* groups = nullptr;
  ConstMatrixView HPHt;
};

/// The rows of a sample as they were used or refused; S and post_fit only of used ones.
struct UsedRows {
  std::span<const std::int64_t> keys;
  const int* groups = nullptr;
  const double* r = nullptr;
  ConstMatrixView R = {}, S = {};    // S = H P⁻ Hᵀ + R
  const double* post_fit = nullptr;  // r − H δ
};

/// Of a statistic that is N(0, 1) in each window of a right filter: the window farthest out.
struct Extreme {
  double score = 0;   // in its own standard deviations
  double figure = 0;  // as the user reads it
  double size = 0;    // how many numbers it is of
  Time since = no_time;
  void see(const Extreme& other) {
    if (other.score > score) *this = other;
  }
};

/// Refusals in a row.
struct Streak {
  std::int64_t count = 0;
  Time since = no_time;
  std::int64_t longest = 0;
  Time longest_since = no_time;
  Time gap = 0;  // from the sample before the first of them
  void refuse(Time t, Time before = no_time) {
    if (count++ == 0) since = t, gap = before == no_time ? 0 : t - before;
    if (count > longest) {
      longest = count;
      longest_since = since;
    }
  }
  void end() { count = 0; }
};

struct Window {
  static constexpr std::int64_t least = 50;
  static constexpr Time shortest = 10 * nanoseconds_per_second;
  std::int64_t count = 0;
  Time since = no_time;
  void use(Time t) {
    if (count++ == 0) since = t;
  }
  bool is_full(Time t) const { return count >= least && t - since >= shortest; }
};

/// One row, by group and key. Lies in the arena.
struct RowMonitor {
  std::int64_t key = 0;
  std::int32_t group = 0;
  std::int32_t is_in_use = 0;
  std::int64_t used = 0, left_out = 0, refused = 0;
  Time last = no_time;    // used or refused
  std::int64_t turn = 0;  // of its measurement's judged samples
  Streak streak;
  double z = 0, zz = 0, lag = 0, rr = 0, HPHt = 0, R = 0;  // sums over all uses; lag: z_k z_{k−1}
  double previous = 0;                                     // z
  Window window;
  double window_z = 0, window_lag = 0;
  std::int64_t windows = 0;
  Extreme bias, correlation;  // of full windows
  // Ten minutes, for a mean too small for a window: since when, and what the sums were then.
  static constexpr Time long_time = 600 * nanoseconds_per_second;
  Time long_since = no_time;
  std::int64_t long_used = 0, longs = 0;
  double long_z = 0;
  Extreme long_bias;
  // Full windows in a row whose mean no right filter has, beyond 5 of its standard deviations, and which is worth a
  // correction, beyond what one sample may be off. From the last of them on: the sum of z, and uses.
  static constexpr double surely = 5, material = 1;
  Streak biased;
  double biased_z = 0, biased_count = 0;
  // Noise over the variance that it claims, by second differences a of r, corrections taken back: d_k = r_k − (r − H δ)_{k−1},
  // a_k = d_k − d_{k−1}. scatter: mean of −a_k a_{k−1} / 4R, which depends neither on the gain (Mehra 1970) nor on a state
  // that jumps, drifts or accelerates; power: of a² / 6R. `widened`: what R is multiplied by.
  static constexpr std::int64_t scatter_memory = 100;
  double post_fit = 0, moved = 0, bent = 0, scatter = 1, power = 1, claim = 0, widened = 1, widest = 1;
  std::int64_t seen = 0;
  Time widened_at = no_time, first_refused = no_time;

  /// Of what is not full yet.
  Extreme open_bias() const;
  Extreme open_correlation() const;
  Extreme open_long_bias() const;

  /// The filter starts anew: windows that are not full yet are of another state.
  void begin_anew();
  /// Returns whether it ended a window that is surely biased, or has been biased for `against`.
  bool use(Time t, std::int64_t its_turn, double r, double its_R, double S, Time against);
  void refuse(Time t, std::int64_t its_turn);
  /// Used or refused. `its_post_fit`: r − H δ; r where it is refused.
  void see(double r, double its_R, double its_post_fit);
  /// Its refusals in a row, none where it was absent from its measurement's samples meanwhile.
  Streak streak_at(std::int64_t now) const { return now - turn <= most_absent ? streak : Streak{}; }
  static constexpr std::int64_t most_absent = 5;
  /// It is locked out, or biased though it passes.
  bool is_against(std::int64_t now, int after) const {
    return after > 0 && (streak_at(now).count >= after || biased.count > 0);
  }
};

/// The NIS of accepted samples. Lies in the arena.
struct NisMonitor {
  Window window;
  double nis = 0;  // sums over the window
  std::int64_t rows = 0;
  std::int64_t windows = 0;
  double newest = 0;  // NIS over rows in the last full window
  Extreme worst;      // of full windows

  /// Of the window that is not full yet.
  Extreme open() const;

  void use(Time t, double its_nis, int its_rows);
  /// As that of a row.
  void begin_anew();
};

/// χ²/d of d degrees of freedom as a normal number, and back.
double normal_score(double ratio, double d);
double ratio_of(double score, double d);

/// The mean of n products of neighbours, y, as a normal number, and back.
double lag_score(double y, double n);
double lag_of(double score, double n);

/// The place of a row in a table, a free one if need be, or that of the row which was not seen for longest. `hint`: where to
/// look first.
RowMonitor& find_row(std::span<RowMonitor> table, int group, std::int64_t key, std::size_t hint);

const RowMonitor* known_row(std::span<const RowMonitor> table, int group, std::int64_t key);

/// What the user reads of it.
RowFigures figures_of(const RowMonitor& row);

}  // namespace binnacle::internal::filter
