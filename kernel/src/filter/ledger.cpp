// SPDX-License-Identifier: Apache-2.0
#include "filter/ledger.hpp"

#include <algorithm>
#include <cstring>

namespace binnacle::filter {

void Ledger::reset() {
  *plan_.health.in(arena_) = Health{};
  for (const auto& measurement : plan_.measurements) {
    *measurement.tally.in(arena_) = Tally{};
    std::fill_n(measurement.left_out.in(arena_), measurement.left_out.count, LeftOut{});
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
  record.measurement = open_;
  record.t = open_t_;
  record.outcome = outcome;
  record.reason = reason;
  close_unobserved(outcome, reason, record.rows, record.nis);  // before the observer, which must not throw but might
  if (observer_) observer_->offered(record);
}

void Ledger::close_unobserved(Outcome outcome, const char* reason, int rows, double nis) {
  Tally& tally = tally_of(open_);
  open_ = -1;
  ++tally.outcomes[static_cast<int>(outcome)];
  if (outcome == Outcome::accepted) {
    tally.nis_sum += nis;
    ++tally.nis_count;
    tally.dof_sum += rows;
    tally.consecutive_gated = 0;
    tally.last_accepted = open_t_;
  } else if (reason[0] != '\0') {
    std::strncpy(tally.last_reason, reason, sizeof tally.last_reason - 1);
  }
}

void Ledger::count_left_out(int measurement, int count, const std::int64_t* keys, const int* groups) {
  tally_of(measurement).rows_left_out += count;
  const auto& place = plan_.measurements[as_size(measurement)].left_out;
  LeftOut* const table = place.in(arena_);
  for (int i = 0; i < count; ++i)
    for (std::size_t k = 0; k < place.count; ++k) {
      if (table[k].count > 0 && (table[k].key != keys[i] || table[k].group != groups[i])) continue;
      table[k] = {keys[i], groups[i], table[k].count + 1};
      break;
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

}  // namespace binnacle::filter
