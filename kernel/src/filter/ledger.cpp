// SPDX-License-Identifier: Apache-2.0
#include "filter/ledger.hpp"

#include <algorithm>
#include <cstring>
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
    tally.last_accepted = record.t;
  } else {
    if (outcome == Outcome::gated) tally.gated.refuse(record.t);
    if (reason[0] != '\0') std::strncpy(tally.last_reason, reason, sizeof tally.last_reason - 1);
  }
  if (observer_) observer_->offered(record);  // at last: it must not throw but might
}

template <class Act>
void Ledger::for_each_row(std::span<const std::int64_t> keys, const int* groups, Act&& act) {
  const auto table = rows_of(open_);
  for (std::size_t i = 0; i < keys.size(); ++i) act(find_row(table, groups[i], keys[i], i), static_cast<int>(i));
}

void Ledger::use(const UsedRows& rows, double nis) {
  for_each_row(rows.keys, rows.groups,
               [&](RowMonitor& row, int i) { row.use(open_t_, judged(open_), rows.r[i], rows.R(i, i), rows.S(i, i)); });
  plan_.measurements[as_size(open_)].nis.in(arena_)->use(open_t_, nis, static_cast<int>(rows.keys.size()));
}

void Ledger::leave_out(std::span<const std::int64_t> keys, const int* groups) {
  tally_of(open_).rows_left_out += static_cast<std::int64_t>(keys.size());
  for_each_row(keys, groups, [](RowMonitor& row, int) { ++row.left_out; });
  refuse(keys, groups);
}

void Ledger::refuse(std::span<const std::int64_t> keys, const int* groups) {
  for_each_row(keys, groups, [&](RowMonitor& row, int) { row.refuse(open_t_, judged(open_)); });
}

bool Ledger::is_locked_out(int measurement, std::span<const std::int64_t> keys, const int* groups,
                           unsigned char* marked) const {
  const auto& plan = plan_.measurements[as_size(measurement)];
  if (plan.recover_after == 0 || !plan.inflations.empty()) return false;
  const auto row_at = [&](std::size_t i) { return known_row(rows_of(measurement), groups[i], keys[i]); };
  const auto streak_of = [&](const RowMonitor* row) { return row ? row->streak_at(judged(measurement)) : Streak{}; };
  // The one that has been refused for longest.
  Streak longest;
  if (!marked) longest = tally(measurement).gated;
  for (std::size_t i = 0; marked && i < keys.size(); ++i)
    if (const Streak streak = streak_of(row_at(i)); marked[i] && streak.count >= longest.count) longest = streak;
  if ((longest.count + 1) % plan.recover_after != 0) return false;
  const Time since = longest.count > 0 ? longest.since : open_t_;

  std::int64_t refused = 0, all = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    // A row that the gate has not come to yet will go the way of its last ones.
    if (marked && streak_of(row_at(i)).count >= std::max(1, plan.recover_after - 1)) marked[i] = 1;
    ++all;
    refused += !marked || marked[i];
  }
  for (int m = 0; m < static_cast<int>(plan_.measurements.size()); ++m)
    for (const RowMonitor& row : rows_of(m)) {
      if (m == measurement || !row.is_in_use || row.last < since) continue;
      ++all;
      refused += plan_.measurements[as_size(m)].recover_after > 0 &&
                 row.streak_at(judged(m)).count >= plan_.measurements[as_size(m)].recover_after;
    }
  return 2 * refused > all || open_t_ - since >= plan.recover_against;
}

bool Ledger::is_inflation_due(int measurement) const {
  const auto& plan = plan_.measurements[as_size(measurement)];
  return plan.recover_after > 0 && !plan.inflations.empty() && tally(measurement).gated.count % plan.recover_after == 0;
}

int Ledger::count_recovery(int measurement, Time t) {
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
    tally_of(m).recoveries_in_vain = 0;
    for (RowMonitor& row : rows_of(m)) row.streak.end();
  }
}

void Ledger::stop(const std::string& diagnosis) {
  Health& health = *plan_.health.in(arena_);
  if (health.is_broken) return;
  std::strncpy(health.diagnosis, diagnosis.c_str(), sizeof health.diagnosis - 1);
  health.is_broken = 1;
}

}  // namespace binnacle::internal::filter
