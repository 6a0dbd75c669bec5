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
    std::fill_n(measurement.left_out.in(arena_), measurement.left_out.count, LeftOutRows{});
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
    tally.consecutive_gated = 0;
    tally.last_accepted = record.t;
  } else if (reason[0] != '\0') {
    std::strncpy(tally.last_reason, reason, sizeof tally.last_reason - 1);
  }
  if (observer_) observer_->offered(record);  // at last: it must not throw but might
}

void Ledger::count_left_out(int measurement, std::span<const std::int64_t> keys, const int* groups) {
  tally_of(measurement).rows_left_out += static_cast<std::int64_t>(keys.size());
  const auto& place = plan_.measurements[as_size(measurement)].left_out;
  const std::span table(place.in(arena_), place.count);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto found = std::ranges::find_if(table, [&](const LeftOutRows& entry) {
      return entry.count == 0 || (entry.key == keys[i] && entry.group == groups[i]);
    });
    if (found != table.end()) *found = {keys[i], groups[i], found->count + 1};
  }
}

bool Ledger::is_recovery_due(int measurement) {
  Tally& tally = tally_of(measurement);
  const int after = plan_.measurements[as_size(measurement)].recover_after;
  ++tally.consecutive_gated;
  if (after == 0 || tally.consecutive_gated < after) return false;
  tally.consecutive_gated = 0;
  ++tally.recoveries;
  return true;
}

void Ledger::stop(const std::string& diagnosis) {
  Health& health = *plan_.health.in(arena_);
  if (health.is_broken) return;
  std::strncpy(health.diagnosis, diagnosis.c_str(), sizeof health.diagnosis - 1);
  health.is_broken = 1;
}

}  // namespace binnacle::internal::filter
