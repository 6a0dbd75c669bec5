// SPDX-License-Identifier: Apache-2.0
#include "filter/intact.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <span>

namespace binnacle::internal::filter {

namespace {

using std::ranges::all_of;

bool are_counts(std::initializer_list<std::int64_t> counts) { return all_of(counts, is_count); }
bool are_lengths(std::initializer_list<Time> lengths) { return all_of(lengths, is_length); }
bool are_times(std::initializer_list<Time> times) { return all_of(times, is_time); }
bool are_moments(std::initializer_list<Time> times) { return all_of(times, base::is_near); }

template <std::size_t N>
bool ends(const char (&text)[N]) {
  return std::memchr(text, '\0', N) != nullptr;
}

bool is_intact(const TimeHead& head, const FilterPlan& plan) {
  return are_times({head.t, head.start, head.first_restart, head.last_start, head.restart_until, head.input_end,
                    head.newest, head.longest_hole_at, head.stopped_at, head.repeats_since, head.longest_repeat_at}) &&
         are_counts({head.steps, head.gaps, head.starts, head.started, head.pending, head.queued, head.changes,
                     head.repeats}) &&
         are_lengths({head.longest_hole, head.stopped_by, head.longest_repeat}) && head.starts < (1 << 30) &&
         as_size(head.pending) <= plan.pending.count && as_size(head.queued) <= plan.queue.count &&
         (head.starts == 0 || are_moments({head.t, head.start, head.last_start, head.input_end})) &&
         (head.started == 0 || head.starts > 0) && (head.repeats == 0 || base::is_near(head.repeats_since)) &&
         (head.t == no_time || head.input_end == no_time || plan.input_channel < 0 || head.started == 0 ||
          head.t <= head.input_end);
}

bool is_intact(const Health& health, const FilterPlan& plan) {
  return ends(health.diagnosis) && health.indefinite_row >= -1 && health.indefinite_row < plan.n &&
         health.unresolved_by >= -1 && health.unresolved_by < static_cast<int>(plan.measurements.size()) &&
         are_times({health.indefinite_at, health.unresolved_at});
}

/// One after the other from the filter's time on.
bool are_intact(std::span<const PendingInput> pending, const TimeHead& head) {
  Time from = head.t;
  return all_of(pending, [&](const PendingInput& input) {
    const bool is_next = are_moments({input.t0, input.t1, input.whole_t0, input.whole_t1}) && input.t0 >= from &&
                         input.t0 < input.t1 && input.whole_t0 < input.whole_t1 && input.t1 <= head.input_end &&
                         std::isfinite(input.whole_dt) && input.whole_dt > 0;
    from = input.t1;
    return is_next;
  });
}

/// Places of data are a permutation, also behind the entries in use.
bool are_intact(std::span<const QueueEntry> queue, int queued, const FilterPlan& plan,
                const std::vector<ChannelPlan>& channels) {
  std::vector<bool> is_taken(queue.size(), false);
  for (const QueueEntry& entry : queue) {
    if (entry.slot < 0 || as_size(entry.slot) >= queue.size() || is_taken[as_size(entry.slot)]) return false;
    is_taken[as_size(entry.slot)] = true;
  }
  return all_of(queue.first(as_size(queued)), [&](const QueueEntry& entry) {
    return entry.measurement >= 0 && as_size(entry.measurement) < plan.measurements.size() &&
           base::is_near(entry.sample.t) &&
           is_intact(entry.sample, channels[as_size(plan.measurements[as_size(entry.measurement)].channel)]);
  });
}

bool is_intact(const Streak& streak) {
  return are_counts({streak.count, streak.longest}) && are_times({streak.since, streak.longest_since}) &&
         (streak.count == 0 || base::is_near(streak.since));
}

bool is_intact(const Window& window) {
  return is_count(window.count) && is_time(window.since) && (window.count == 0 || base::is_near(window.since));
}

bool are_intact(std::initializer_list<Extreme> extremes) {
  return all_of(extremes, [](const Extreme& extreme) { return is_time(extreme.since); });
}

bool is_intact(const Tally& tally) {
  const auto count = [&](Outcome outcome) { return tally.by_outcome[static_cast<int>(outcome)]; };
  const std::int64_t uses = count(Outcome::accepted) + count(Outcome::withheld);
  return all_of(tally.by_outcome, is_count) &&
         are_counts({tally.offered, tally.before_start, tally.recoveries, tally.rows_left_out, tally.rows_used,
                     tally.nis_count, tally.replayed, tally.iterated, tally.iterations, tally.not_converged,
                     tally.linearized, tally.reached, tally.recoveries_in_vain, tally.changes, tally.repeated,
                     tally.believable, tally.is_widened, tally.absurd, tally.unconfirmed}) &&
         are_lengths({tally.longest_delay, tally.longest_silence, tally.first_silence}) && is_intact(tally.gated) &&
         is_intact(tally.repeats) && tally.repeated <= count(Outcome::gated) &&
         are_times({tally.last_accepted, tally.first_recovery, tally.last_recovery, tally.last_useful,
                    tally.longest_silence_at, tally.first_useful}) &&
         (uses == 0 || are_moments({tally.last_useful, tally.first_useful})) && ends(tally.last_reason);
}

bool is_intact(const NisMonitor& nis) {
  return is_intact(nis.window) && are_counts({nis.rows, nis.windows}) && are_intact({nis.worst});
}

/// `groups`: so many have names.
bool is_intact(const RowMonitor& row, int groups) {
  return row.group >= 0 && row.group < groups &&
         are_counts({row.used, row.left_out, row.refused, row.turn, row.windows, row.long_used, row.longs, row.seen}) &&
         row.long_used <= row.used && is_intact(row.streak) && is_intact(row.biased) && is_intact(row.window) &&
         are_times({row.last, row.long_since, row.widened_at, row.first_refused}) &&
         (row.used == 0 || base::is_near(row.last)) && are_intact({row.bias, row.correlation, row.long_bias});
}

bool is_intact(const MeasurementPlan& measurement, const std::byte* arena) {
  const int groups = static_cast<int>(measurement.systematic.size());
  const std::span rows(measurement.rows.in(arena), measurement.rows.count);
  return is_intact(*measurement.tally.in(arena)) && is_intact(*measurement.nis.in(arena)) &&
         all_of(rows, [&](const RowMonitor& row) { return is_intact(row, groups); });
}

}  // namespace

bool is_intact(const SampleHead& head, const ChannelPlan& channel) {
  return are_times({head.t, head.t0}) && (head.t0 == no_time || head.t0 < head.t) && head.rows >= 0 &&
         head.rows <= channel.declaration.max_rows && (head.has_covariance == 0 || channel.covariance_dof > 0);
}

bool is_intact(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, const std::byte* arena) {
  const TimeHead& head = *plan.head.in(arena);
  const auto are_latest = [&](const std::vector<LatestPlan>& list) {
    return all_of(list, [&](const LatestPlan& latest) {
      return is_intact(*latest.head.in(arena), channels[as_size(latest.channel)]);
    });
  };
  return is_intact(head, plan) && is_intact(*plan.health.in(arena), plan) &&
         are_intact(std::span(plan.pending.in(arena), as_size(head.pending)), head) &&
         are_intact(std::span(plan.queue.in(arena), plan.queue.count), head.queued, plan, channels) &&
         are_latest(plan.initial) && are_latest(plan.auxiliary) &&
         all_of(plan.measurements, [&](const MeasurementPlan& its) { return is_intact(its, arena); });
}

}  // namespace binnacle::internal::filter
