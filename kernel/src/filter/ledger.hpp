// SPDX-License-Identifier: Apache-2.0
// What becomes of a filter and of each sample offered to it: exactly one outcome, whatever throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "binnacle/step_log.hpp"
#include "filter/definite.hpp"
#include "filter/plan.hpp"

namespace binnacle::internal::filter {

/// Whether rows that disagree with the state are believed, since most of what came does, or since they did for long.
enum class Belief : unsigned char { none, by_votes, by_time, by_scatter };

/// An offered sample is open until it is closed with its outcome or waits in the queue; at most one is open. So
///     offered = Σ outcomes + waiting + open.
class Ledger {
 public:
  Ledger(const FilterPlan& plan, std::byte* arena)
      : plan_(plan), arena_(arena), factor_(as_size(plan.n) * as_size(plan.n)) {}

  void reset();
  void attach(StepObserver* observer) { observer_ = observer; }
  StepObserver* observer() const { return observer_; }
  Wants wants() const { return observer_ ? observer_->wants() : Wants::nothing; }

  /// A sample from before the start is offered to nobody.
  void count_before_start(int measurement) { ++tally_of(measurement).before_start; }
  void count_replayed(int measurement, Time late) {
    Tally& tally = tally_of(measurement);
    ++tally.replayed;
    tally.longest_delay = std::max(tally.longest_delay, late);
  }
  void count_iterations(int measurement, int iterations, bool has_converged) {
    Tally& tally = tally_of(measurement);
    ++tally.iterated;
    tally.iterations += iterations;
    tally.not_converged += !has_converged;
  }
  void count_linearized(int measurement) { ++tally_of(measurement).linearized; }
  void open(int measurement, Time t);
  /// The open sample waits until it is reopened.
  void wait() { open_ = -1; }
  void reopen(int measurement, Time t);
  bool has_open() const { return open_ >= 0; }
  /// The filter's time has reached the open sample.
  void reach() { ++tally_of(open_).reached; }
  /// `record` holds what is known of it beside measurement, time, outcome and reason; the observer sees it.
  void close(Outcome outcome, const char* reason, UpdateRecord record = {});

  /// Rows of the open sample, which is accepted: those that were used, and those that a gate by row or key left out.
  /// use() returns whether it is time to ask is_biased().
  bool use(const UsedRows& rows, double nis);
  void leave_out(const UsedRows& rows);
  /// All rows of the open sample are gated with it.
  void refuse(const UsedRows& rows);
  /// R by what its rows are widened.
  void widen_noise(int measurement, const OfferedRows& rows, MatrixView R) const;
  /// Whether the marked rows of the open sample (null: all), refused once more, are to be recovered. The groups that came
  /// since their first refusal have a vote each; that of a group is against the state where more of its rows are locked
  /// out than pass, a row that passes counting as its squared correlation with one that does not: the north says nothing
  /// about the east. Where most are against the state, it is wrong; else the measurement is, and only after `against`
  /// the state is taken to be. Marks the other rows that are locked out with them.
  /// is_confirmed(): another measurement is against the state too, or this one was missing before, as in a tunnel.
  Belief is_locked_out(int measurement, const OfferedRows& rows, unsigned char* marked);
  bool is_confirmed() const { return is_confirmed_; }
  /// Whether the state is to be taken for wrong since rows of a sample that was accepted are biased, by the same rule. Marks
  /// them, and writes the mean of z from their last window on, and of how many it is; in other rows zero, of one.
  Belief is_biased(int measurement, const OfferedRows& rows, Time t, unsigned char* marked, double* z, double* counts);
  /// Whether a sample repeats the one before it to the bit, of a sensor that does not always.
  bool repeats(int measurement, const SampleView& sample, const ChannelPlan& channel);
  /// It is refused: a sensor that hangs means nothing for the state.
  void count_repeat(int measurement, Time t) { tally_of(measurement).repeats.refuse(t); }
  /// The newest sample of a measurement was gated: whether the variances that its config names are due.
  bool is_inflation_due(int measurement) const;
  /// Returns how many there were in a row, each within `against` of the one before.
  std::int64_t count_recovery(int measurement, Time t);
  void count_unconfirmed(int measurement, double z) {  // Estimator::unconfirmed
    ++tally_of(measurement).unconfirmed;
    tally_of(measurement).absurd += z > Tally::beyond_reason;
  }
  /// The filter starts anew.
  void forget_refusals();

  /// Looks whether P is a covariance, which the diagonal alone does not say; keeps when it was farthest from one.
  void examine(const CovarianceForm& P, Time t);
  /// What an update sees is so many times its noise, more than P has digits for.
  void note_unresolved(int measurement, double ratio, Time t);
  const Health& health() const { return *plan_.health.in(arena_); }
  /// Of P as it is now. Allocates nothing.
  VarianceLeft indefinite(const CovarianceForm& P) const;

  /// The filter stops.
  void stop(const std::string& diagnosis);
  bool is_broken() const { return plan_.health.in(arena_)->is_broken != 0; }
  /// Empty while the filter is well.
  const char* diagnosis() const { return plan_.health.in(arena_)->diagnosis; }

  const Tally& tally(int measurement) const { return *plan_.measurements[as_size(measurement)].tally.in(arena_); }
  /// How many samples of a measurement a gate has judged, without repetitions.
  std::int64_t judged(int measurement) const {
    const auto& outcomes = tally(measurement).by_outcome;
    return outcomes[static_cast<int>(Outcome::accepted)] + outcomes[static_cast<int>(Outcome::gated)] -
           tally(measurement).repeated;
  }
  /// Samples that were of use.
  std::int64_t uses(int measurement) const {
    const auto& outcomes = tally(measurement).by_outcome;
    return outcomes[static_cast<int>(Outcome::accepted)] + outcomes[static_cast<int>(Outcome::withheld)];
  }
  const NisMonitor& nis(int measurement) const { return *plan_.measurements[as_size(measurement)].nis.in(arena_); }
  /// Free places among them.
  std::span<const RowMonitor> rows(int measurement) const { return rows_of(measurement); }

  /// A sample of the measurement is of use now: it is about to correct, or is withheld.
  void end_silence(int measurement, Time t, const CovarianceForm& P);
  /// It has corrected: how certain is what it sees.
  void settle(int measurement, Time t, const CovarianceForm& P);
  Time usual_interval(int measurement) const {
    const Tally& its = tally(measurement);
    return uses(measurement) > 1 ? (its.last_useful - its.first_useful) / (uses(measurement) - 1) : 0;
  }
  /// A slow sensor is not silent: so many of its mean intervals are.
  static constexpr std::int64_t many_intervals = 10;
  /// Since the last sample of use, if what the measurement sees has become much less certain; else 0.
  Time silence(int measurement, Time t, const CovarianceForm& P) const;

  /// What the monitors make of it so far. Writes as many reasons as there is room for; returns how many there are.
  Verdict verdict(const CovarianceForm& P) const;
  std::size_t reasons(const CovarianceForm& P, std::span<TrustReason> into) const;

 private:
  std::span<RowMonitor> rows_of(int measurement) const {
    const auto& place = plan_.measurements[as_size(measurement)].rows;
    return {place.in(arena_), place.count};
  }
  struct Votes {
    int against = 0, all = 0;
  };
  static Votes votes_of(const OfferedRows& rows, const unsigned char* marked);
  Belief belief_in(int measurement, const OfferedRows& rows, const unsigned char* marked, Time t, Time since) const;
  /// R of the marked rows (null: all) of a group, if they surely scatter by more than it was widened for, and P would be opened
  /// for them or one was refused often and for long.
  bool widen(int measurement, const OfferedRows& rows, const unsigned char* marked, int group, bool would_open);
  Votes votes_of_others(int measurement, Time since) const;
  template <class Act>
  void for_each_row(const UsedRows& rows, Act&& act);
  Tally& tally_of(int measurement) { return *plan_.measurements[as_size(measurement)].tally.in(arena_); }

  const FilterPlan& plan_;
  std::byte* arena_;
  mutable std::vector<double> factor_;  // scratch
  StepObserver* observer_ = nullptr;
  mutable bool is_confirmed_ = false;
  int open_ = -1;              // measurement of the open sample
  bool open_repeats_ = false;  // it repeats the one before
  Time open_t_ = no_time;
};

}  // namespace binnacle::internal::filter
