// SPDX-License-Identifier: Apache-2.0
#include "filter/ledger.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace binnacle::internal::filter {

void Ledger::reset() {
  *plan_.health.in(arena_) = Health{};
  for (const auto& measurement : plan_.measurements) {
    *measurement.tally.in(arena_) = Tally{};
    *measurement.nis.in(arena_) = NisMonitor{};
    std::fill_n(measurement.rows.in(arena_), measurement.rows.count, RowMonitor{});
  }
  open_ = -1;
}

void Ledger::open(int measurement, Time t) {
  ++tally_of(measurement).offered;
  reopen(measurement, t);
}

void Ledger::reopen(int measurement, Time t) {
  open_ = measurement;
  open_t_ = t;
  open_repeats_ = false;
}

void Ledger::close(Outcome outcome, const char* reason, UpdateRecord record) {
  record.measurement = std::exchange(open_, -1);
  record.t = open_t_;
  record.outcome = outcome;
  record.reason = reason;
  Tally& tally = tally_of(record.measurement);
  ++tally.by_outcome[static_cast<int>(outcome)];
  if (outcome == Outcome::accepted) {
    tally.nis_sum += record.nis;
    ++tally.nis_count;
    tally.rows_used += record.rows;
    tally.gated.end();
    tally.believable = 0;
    tally.last_accepted = record.t;
  } else {
    if (outcome == Outcome::gated) {
      tally.gated.refuse(record.t, tally.last_useful);
      ++(open_repeats_ ? tally.repeated : tally.believable);
    }
    if (reason[0] != '\0') std::strncpy(tally.last_reason, reason, sizeof tally.last_reason - 1);
  }
  if (observer_) observer_->offered(record);  // at last: it must not throw but might
}

template <class Act>
void Ledger::for_each_row(const UsedRows& rows, Act&& act) {
  const auto table = rows_of(open_);
  for (std::size_t i = 0; i < rows.keys.size(); ++i) act(find_row(table, rows.groups[i], rows.keys[i], i), int(i));
}

bool Ledger::use(const UsedRows& rows, double nis) {
  bool is_biased = false;
  const std::int64_t turn = judged(open_);
  const Time against = plan_.measurements[as_size(open_)].recover_against;
  for_each_row(rows, [&](RowMonitor& row, int i) {
    is_biased |= row.use(open_t_, turn, rows.r[i], rows.R(i, i), rows.S(i, i), against);
    if (rows.post_fit) row.see(rows.r[i], rows.R(i, i), rows.post_fit[i]);
  });
  plan_.measurements[as_size(open_)].nis.in(arena_)->use(open_t_, nis, static_cast<int>(rows.keys.size()));
  return is_biased;
}

void Ledger::leave_out(const UsedRows& rows) {
  tally_of(open_).rows_left_out += static_cast<std::int64_t>(rows.keys.size());
  for_each_row(rows, [](RowMonitor& row, int) { ++row.left_out; });
  refuse(rows);
}

void Ledger::refuse(const UsedRows& rows) {
  const bool widens = plan_.measurements[as_size(open_)].widens;
  for_each_row(rows, [&](RowMonitor& row, int i) {
    row.refuse(open_t_, judged(open_));
    if (widens) row.see(rows.r[i], rows.R(i, i), rows.r[i]);
  });
}

/// The mean of n products of white noise has the variance 7 / n.
bool Ledger::widen(int measurement, const OfferedRows& rows, const unsigned char* marked, int group, bool would_open) {
  constexpr double surely_so = 4, least = 7, most = 1e4;
  // A quarter of the samples in at least the time after which they are believed: fewer are outliers.
  constexpr std::int64_t many = 20;
  const Time against = plan_.measurements[as_size(measurement)].recover_against;
  double scatter = 0, widened = 0, n = 0, all = 0;
  bool is_due = would_open;
  const auto for_each = [&](auto&& act) {
    for (std::size_t i = 0; i < rows.keys.size(); ++i)
      if (rows.groups[i] == group && (!marked || marked[i]))
        act(find_row(rows_of(measurement), group, rows.keys[i], i));
  };
  for_each([&](const RowMonitor& row) {
    scatter += row.scatter;
    widened += row.widened;
    is_due |= row.refused >= std::max(many, row.seen / 4) && open_t_ - row.first_refused >= against;
    ++all;
    n += static_cast<double>(std::min(row.seen, RowMonitor::scatter_memory));
  });
  const double surely = widened * (1 + surely_so * std::sqrt(7 / n));
  if (!is_due || n < least || scatter <= surely || scatter > most * all) return false;
  for_each([&](RowMonitor& row) {
    row.widest = std::max(row.widest, row.widened *= scatter / widened);
    if (row.widened_at == no_time) row.widened_at = open_t_;
  });
  Tally& its = tally_of(measurement);
  its.is_widened = 1;
  its.unconfirmed = its.absurd;  // what was recovered before is explained
  return true;
}

void Ledger::widen_noise(int measurement, const OfferedRows& rows, MatrixView R) const {
  if (!tally(measurement).is_widened) return;
  for (std::size_t i = 0; i < rows.keys.size(); ++i) {
    const RowMonitor* const row = known_row(rows_of(measurement), rows.groups[i], rows.keys[i]);
    const double root = row ? std::sqrt(row->widened) : 1.0;
    R.as().row(static_cast<int>(i)) *= root;
    R.as().col(static_cast<int>(i)) *= root;
  }
}

Belief Ledger::is_locked_out(int measurement, const OfferedRows& rows, unsigned char* marked) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  if (plan.recover_after == 0 || !plan.inflations.empty()) return Belief::none;
  const std::size_t count = rows.keys.size();
  const auto streak_of = [&](std::size_t i) {
    const RowMonitor* row = known_row(rows_of(measurement), rows.groups[i], rows.keys[i]);
    return row ? row->streak_at(judged(measurement)) : Streak{};
  };
  // The one that has been refused for longest.
  Streak longest;
  if (!marked) {
    longest = tally(measurement).gated;
    longest.count = tally(measurement).believable;
  }
  for (std::size_t i = 0; marked && i < count; ++i)
    if (const Streak streak = streak_of(i); marked[i] && streak.count >= longest.count) longest = streak;
  constexpr unsigned char also = 2;
  Belief belief = Belief::none;
  if ((longest.count + 1) % plan.recover_after == 0) {
    // A row that the gate has not come to yet will go the way of its last ones.
    for (std::size_t i = 0; marked && i < count; ++i)
      if (!marked[i] && streak_of(i).count >= std::max(1, plan.recover_after - 1)) marked[i] = also;
    belief = belief_in(measurement, rows, marked, open_t_, longest.count > 0 ? longest.since : open_t_);
    is_confirmed_ |= longest.gap > many_intervals * usual_interval(measurement);
  }
  const bool would_open = belief != Belief::none;
  for (std::size_t i = 0; plan.widens && i < count; ++i)
    if (widen(measurement, rows, marked, rows.groups[i], would_open)) belief = Belief::by_scatter;
  if (belief == Belief::none && marked) std::replace(marked, marked + count, also, static_cast<unsigned char>(0));
  return belief;
}

Belief Ledger::is_biased(int measurement, const OfferedRows& rows, Time t, unsigned char* marked, double* z,
                         double* counts) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  if (plan.recover_after == 0 || !plan.inflations.empty()) return Belief::none;
  const auto row_of = [&](std::size_t i) -> RowMonitor& {
    return find_row(rows_of(measurement), rows.groups[i], rows.keys[i], i);
  };
  Time since = t;
  for (std::size_t i = 0; i < rows.keys.size(); ++i) {
    const RowMonitor& row = row_of(i);
    marked[i] = row.biased.count > 0;
    z[i] = marked[i] ? row.biased_z / row.biased_count : 0.0;
    counts[i] = marked[i] ? row.biased_count : 1.0;
    if (marked[i]) since = std::min(since, row.biased.since);
  }
  const Belief belief = belief_in(measurement, rows, marked, t, since);
  if (belief == Belief::none) return belief;
  for (std::size_t i = 0; i < rows.keys.size(); ++i)
    if (marked[i]) row_of(i).biased.end();
  return belief;
}

Belief Ledger::belief_in(int measurement, const OfferedRows& rows, const unsigned char* marked, Time t,
                         Time since) const {
  const int own = marked ? 0 : 1;
  const Votes votes = votes_of(rows, marked);
  const Votes others = votes_of_others(measurement, since);
  is_confirmed_ = others.against > 0;
  const int against = own + votes.against + others.against, all = own + votes.all + others.all;
  if (2 * against > all) return Belief::by_votes;
  return t - since >= plan_.measurements[as_size(measurement)].recover_against ? Belief::by_time : Belief::none;
}

/// One for each group of the sample; none without marks, where the sample has one vote.
Ledger::Votes Ledger::votes_of(const OfferedRows& rows, const unsigned char* marked) {
  Votes votes;
  if (!marked) return votes;
  const auto& groups = rows.groups;
  const int count = static_cast<int>(rows.keys.size());
  const auto squared_correlation = [&](int i, int k) {
    const double product = rows.HPHt(i, i) * rows.HPHt(k, k);
    return product > 0 ? rows.HPHt(i, k) * rows.HPHt(i, k) / product : 0.0;
  };
  for (int first = 0; first < count; ++first) {
    if (std::find(groups, groups + first, groups[first]) != groups + first) continue;
    double refused = 0, passing = 0;
    for (int i = first; i < count; ++i) {
      if (groups[i] != groups[first]) continue;
      if (marked[i]) {
        ++refused;
        continue;
      }
      double closest = 0;
      for (int k = first; k < count; ++k)
        if (groups[k] == groups[first] && marked[k]) closest = std::max(closest, squared_correlation(i, k));
      passing += closest;
    }
    ++votes.all;
    votes.against += refused > passing;
  }
  return votes;
}

/// One for each group of other measurements of which rows came since. What has no gate passes always, and has none.
Ledger::Votes Ledger::votes_of_others(int measurement, Time since) const {
  Votes votes;
  for (int m = 0; m < static_cast<int>(plan_.measurements.size()); ++m) {
    const auto& plan = plan_.measurements[as_size(m)];
    if (m == measurement || plan.gate <= 0) continue;
    const int after = plan.recover_after;
    const auto table = rows_of(m);
    const auto came = [&](const RowMonitor& row) { return row.is_in_use && row.last >= since; };
    for (std::size_t first = 0; first < table.size(); ++first) {
      const int group = table[first].group;
      const auto is_same = [&](const RowMonitor& row) { return came(row) && row.group == group; };
      if (!came(table[first]) ||
          std::any_of(table.begin(), table.begin() + static_cast<std::ptrdiff_t>(first), is_same))
        continue;
      const auto passes = [&](const RowMonitor& row) { return is_same(row) && row.streak.count == 0; };
      const auto is_against = [&](const RowMonitor& row) { return is_same(row) && row.is_against(judged(m), after); };
      // Without recovery a refusal says nothing about the state: a vehicle that does not stand.
      if (after == 0 && std::ranges::none_of(table, passes)) continue;
      ++votes.all;
      votes.against += 2 * std::ranges::count_if(table, is_against) > std::ranges::count_if(table, is_same);
    }
  }
  return votes;
}

bool Ledger::repeats(int measurement, const SampleView& sample, const ChannelPlan& channel) {
  Tally& its = tally_of(measurement);
  std::uint64_t fingerprint = 14695981039346656037U;  // FNV-1a, word by word
  const auto mix = [&](const double* values, int count) {
    for (int i = 0; i < count; ++i)
      fingerprint = (fingerprint ^ std::bit_cast<std::uint64_t>(values[i])) * 1099511628211U;
  };
  mix(sample.fields, channel.epoch_fields);
  mix(sample.row_fields, sample.rows * channel.row_fields);
  if (std::exchange(its.fingerprint, fingerprint) != fingerprint) {
    ++its.changes;
    its.repeats.end();
    return false;
  }
  constexpr std::int64_t least = 20;
  open_repeats_ = its.changes >= least;
  return open_repeats_;
}

Time Ledger::silence(int measurement, Time t, const CovarianceForm& P) const {
  const auto& plan = plan_.measurements[as_size(measurement)];
  const Time last = tally(measurement).last_useful;
  if (!plan.is_watched || plan_.trust.silent <= 0 || last == no_time || t - last < plan_.trust.silent) return 0;
  const Time since = last - plan_.head.in(arena_)->start;
  // The mean interval against a part of the silence, divided: a product of the silence and the uses is beyond 63 bits.
  if (since > 0 && (since - 1) / std::max<std::int64_t>(1, uses(measurement)) >= (t - last) / many_intervals) return 0;
  constexpr double much = 3 * 3;  // of the variance
  const double* const then = plan.variances.in(arena_);
  for (std::size_t c = 0; c < plan.columns.size(); ++c)
    if (P.variance(plan.columns[c]) > much * then[c]) return t - last;
  return 0;
}

void Ledger::end_silence(int measurement, Time t, const CovarianceForm& P) {
  Tally& its = tally_of(measurement);
  const Time silent = silence(measurement, t, P);
  if (its.first_useful == no_time) {
    its.first_useful = t;
    its.first_silence = silent;
    return;
  }
  if (silent <= its.longest_silence) return;
  its.longest_silence = silent;
  its.longest_silence_at = its.last_useful;
}

void Ledger::settle(int measurement, Time t, const CovarianceForm& P) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  tally_of(measurement).last_useful = t;
  double* const variances = plan.variances.in(arena_);
  P.variances(plan.columns, variances);
}

bool Ledger::is_inflation_due(int measurement) const {
  const auto& plan = plan_.measurements[as_size(measurement)];
  return plan.recover_after > 0 && !plan.inflations.empty() && tally(measurement).believable % plan.recover_after == 0;
}

std::int64_t Ledger::count_recovery(int measurement, Time t) {
  Tally& tally = tally_of(measurement);
  if (tally.recoveries++ == 0) tally.first_recovery = t;
  const bool is_soon = tally.last_recovery != no_time &&
                       t - tally.last_recovery < plan_.measurements[as_size(measurement)].recover_against;
  tally.recoveries_in_vain = is_soon ? tally.recoveries_in_vain + 1 : 1;
  tally.last_recovery = t;
  return tally.recoveries_in_vain;
}

void Ledger::forget_refusals() {
  for (int m = 0; m < static_cast<int>(plan_.measurements.size()); ++m) {
    tally_of(m).gated.end();
    tally_of(m).believable = tally_of(m).recoveries_in_vain = 0;
    plan_.measurements[as_size(m)].nis.in(arena_)->begin_anew();
    for (RowMonitor& row : rows_of(m)) {
      row.streak.end();
      row.begin_anew();
    }
  }
}

void Ledger::stop(const std::string& diagnosis) {
  Health& health = *plan_.health.in(arena_);
  if (health.is_broken) return;
  std::strncpy(health.diagnosis, diagnosis.c_str(), sizeof health.diagnosis - 1);
  health.is_broken = 1;
}

}  // namespace binnacle::internal::filter
