// SPDX-License-Identifier: Apache-2.0
// The verdict: what a filter's monitors say against its estimates.
#include <algorithm>
#include <cmath>

#include <boost/math/distributions/normal.hpp>

#include "filter/ledger.hpp"

namespace binnacle::internal::filter {

namespace {

constexpr double ten_minutes = 600;

/// Goes through the monitors of one filter and gives `see` each reason.
template <class See>
class Examination {
 public:
  Examination(const FilterPlan& plan, const std::byte* arena, const Ledger& ledger, const CovarianceForm& P, See& see)
      : plan_(plan), trust_(plan.trust), head_(*plan.head.in(arena)), ledger_(ledger), P_(P), see_(see) {}

  void run() {
    if (head_.starts == 0) return;
    if (head_.started == 0)
      see_({.doubt = Doubt::stopped,
            .verdict = Verdict::lost,
            .since = head_.stopped_at,
            .figure = seconds(head_.stopped_by),
            .limit = seconds(plan_.longest_bridge)});
    if (head_.starts > 1) {
      const bool is_by_hole = head_.starts == 2 && head_.stopped_by > 0 && head_.stopped_at < head_.first_restart;
      see_({Doubt::restarted, Verdict::doubtful, -1, -1, 0, head_.first_restart, double(head_.starts - 1),
            is_by_hole ? seconds(head_.stopped_by) : 0.0});
    }
    examine_covariance();
    if (is_unaided()) see_({.doubt = Doubt::unaided, .verdict = Verdict::lost});
    find_score_limits();
    for (int m = 0; m < static_cast<int>(plan_.measurements.size()); ++m)
      if (plan_.measurements[as_size(m)].is_watched) examine(m);
    see_lasting(Doubt::bridged, head_.longest_hole_at, head_.longest_hole, trust_.hole);
    if (plan_.input_channel >= 0 && head_.newest > head_.input_end)
      see_lasting(Doubt::input_ended, head_.input_end, head_.newest - head_.input_end, trust_.silent, Verdict::lost);
    see_lasting(Doubt::frozen, head_.longest_repeat_at, head_.longest_repeat, trust_.frozen);
  }

 private:
  void see_lasting(Doubt doubt, Time since, Time lasted, Time limit, Verdict verdict = Verdict::doubtful) {
    if (limit > 0 && lasted > limit)
      see_({.doubt = doubt, .verdict = verdict, .since = since, .figure = seconds(lasted), .limit = seconds(limit)});
  }

  /// P as it is now, or as it was found before; and what it could not hold.
  void examine_covariance() {
    constexpr double gross = 1e-3;
    const Health& health = ledger_.health();
    VarianceLeft least{health.indefinite_row, health.indefinite_share};
    Time since = health.indefinite_at;
    if (const auto now = head_.started != 0 ? ledger_.indefinite(P_) : VarianceLeft{};
        now.row >= 0 && now.share < least.share) {
      if (least.row < 0) since = head_.t;
      least = now;
    }
    if (least.row >= 0)
      see_({Doubt::indefinite, least.share < -gross ? Verdict::lost : Verdict::doubtful, -1, -1, least.row, since,
            least.share, definite_within});
    if (health.unresolved_by >= 0)
      see_({Doubt::unresolved, Verdict::doubtful, health.unresolved_by, -1, 0, health.unresolved_at,
            health.unresolved_ratio, unresolved_from});
  }

  /// It has measurements, and no sample of any was of use. What a filter never meant to use is not missed.
  bool is_unaided() const {
    bool is_watched = false;
    for (int m = 0; m < static_cast<int>(plan_.measurements.size()); ++m) {
      const Tally& tally = ledger_.tally(m);
      if (count(tally, Outcome::accepted) + count(tally, Outcome::withheld) > 0) return false;
      is_watched = is_watched || plan_.measurements[as_size(m)].is_watched;
    }
    return is_watched && trust_.after > 0 && head_.steps > 0;
  }

  /// Where components are considered (Schmidt), innovations of a right filter are not white.
  bool is_tested(int m) const {
    const auto& measurement = plan_.measurements[as_size(m)];
    return measurement.is_watched && std::ranges::all_of(measurement.columns, [&](int column) {
             return plan_.corrected.empty() || plan_.corrected[as_size(column)] != 0;
           });
  }

  /// The tests of innovations share the probability of a false alarm (Bonferroni), those of means over ten minutes one
  /// half of it: the score which a right filter passes with a probability of
  ///     1 − false_alarm / 2 · (its run in units of ten minutes, at least one) / tests .
  /// What is not full yet counts.
  void find_score_limits() {
    std::int64_t windows = 0, longs = 0;
    for (int m = 0; m < static_cast<int>(plan_.measurements.size()); ++m) {
      if (!is_tested(m)) continue;
      if (trust_.tests_nis) windows += ledger_.nis(m).windows + 1;
      // The test of a bias has two sides.
      for (const RowMonitor& row : ledger_.rows(m)) {
        if (row.used == 0) continue;
        windows += (row.windows + 1) * (2 * trust_.tests_bias + trust_.tests_correlation);
        longs += (row.longs + 1) * 2 * trust_.tests_bias;
      }
    }
    const double runs = std::max(1.0, seconds(head_.t - head_.start) / ten_minutes);
    const auto limit = [&](std::int64_t tests) {
      if (tests == 0 || trust_.false_alarm <= 0) return 0.0;
      const double probability = std::min(0.1, trust_.false_alarm / 2 * runs / static_cast<double>(tests));
      return boost::math::quantile(boost::math::complement(boost::math::normal(), probability));
    };
    score_limit_ = limit(windows);
    long_limit_ = limit(longs);
  }

  void examine(int m) {
    const Tally& tally = ledger_.tally(m);
    const std::int64_t useful = count(tally, Outcome::accepted) + count(tally, Outcome::withheld);
    const std::int64_t refused = count(tally, Outcome::gated) + count(tally, Outcome::invalid) +
                                 count(tally, Outcome::rejected) + count(tally, Outcome::late);
    if (trust_.after > 0 && useful == 0 && refused >= trust_.after) {
      see_({Doubt::never_accepted, Verdict::lost, m, -1, 0, no_time, double(refused), double(trust_.after)});
      return;
    }
    examine_lock_out(m, tally);
    examine_share(m, tally);
    if (tally.recoveries > 0)
      see_({Doubt::recovered, tally.unconfirmed > 0 ? Verdict::lost : Verdict::doubtful, m, -1, 0, tally.first_recovery,
            double(tally.recoveries), double(tally.unconfirmed)});
    if (tally.repeats.longest >= trust_.after && trust_.after > 0)
      see_({Doubt::frozen, Verdict::ok, m, -1, 0, tally.repeats.longest_since, double(tally.repeats.longest),
            double(trust_.after)});
    examine_silence(m, tally);
    constexpr double bygone = 2;  // it scatters about as it claims again
    for (const RowMonitor& row : ledger_.rows(m))
      if (row.widened_at != no_time)
        see_({Doubt::scattered, row.widened < bygone ? Verdict::ok : Verdict::doubtful, m, row.group, row.key,
              row.widened_at, std::sqrt(row.claim * row.widest), std::sqrt(row.claim)});
    if (score_limit_ > 0 && is_tested(m)) examine_innovations(m);
  }

  /// Up to now, before, or up to the first sample of use: how often it comes is known only from the second on.
  void examine_silence(int m, const Tally& tally) {
    const Time many = Ledger::many_intervals * ledger_.usual_interval(m);
    const Time first = tally.first_silence > many ? tally.first_silence : 0;
    const Time now = ledger_.silence(m, head_.t, P_), longest = std::max({first, now, tally.longest_silence});
    if (longest == 0) return;
    const Time since = longest == now     ? tally.last_useful
                       : longest == first ? tally.first_useful - first
                                          : tally.longest_silence_at;
    see_({Doubt::silent, Verdict::doubtful, m, -1, 0, since, seconds(longest), seconds(trust_.silent)});
  }

  /// All that is refused together is one reason; rows one by one where others pass.
  void examine_lock_out(int m, const Tally& tally) {
    const auto& measurement = plan_.measurements[as_size(m)];
    if (trust_.after == 0 || measurement.recover_after == 0) return;
    if (tally.gated.count >= trust_.after) {
      see_(locked_out(m, Verdict::lost, -1, 0, tally.gated));
      return;
    }
    if (measurement.gate_unit == GateUnit::sample) {
      if (tally.gated.longest >= trust_.after) see_(was_locked_out(m, -1, 0, tally.gated));
      return;
    }
    const std::int64_t now = ledger_.judged(m);
    const auto is_out = [&](const RowMonitor& row) { return row.streak_at(now).count >= trust_.after; };
    std::int64_t out = 0, all = 0;
    for (const RowMonitor& row : ledger_.rows(m)) {
      all += row.is_in_use && now - row.turn <= RowMonitor::most_absent;
      out += is_out(row);
    }
    for (const RowMonitor& row : ledger_.rows(m))
      if (is_out(row))
        see_(locked_out(m, 2 * out > all ? Verdict::lost : Verdict::doubtful, row.group, row.key, row.streak));
      else if (row.streak.longest >= trust_.after)
        see_(was_locked_out(m, row.group, row.key, row.streak));
  }

  TrustReason locked_out(int m, Verdict verdict, int group, std::int64_t key, const Streak& streak) const {
    return {Doubt::locked_out, verdict, m, group, key, streak.since, double(streak.count), double(trust_.after)};
  }

  TrustReason was_locked_out(int m, int group, std::int64_t key, const Streak& streak) const {
    return {Doubt::was_locked_out,  Verdict::ok,         m, group, key, streak.longest_since,
            double(streak.longest), double(trust_.after)};
  }

  /// Of a part's rows by the gate, the worst part's, or of samples that came late.
  void examine_share(int m, const Tally& tally) {
    constexpr std::int64_t least = 10;
    if (trust_.refused <= 0) return;
    double worst = 0;
    const auto note = [&](std::int64_t part, std::int64_t all) {
      if (part >= least) worst = std::max(worst, double(part) / double(all));
    };
    for (const RowMonitor& first : ledger_.rows(m)) {
      std::int64_t used = 0, refused = 0;
      for (const RowMonitor& row : ledger_.rows(m)) {
        if (row.group != first.group) continue;
        used += row.used;
        refused += row.refused;
      }
      note(refused, used + refused);
    }
    note(count(tally, Outcome::late), tally.offered - count(tally, Outcome::withheld));
    if (worst > trust_.refused) see_({Doubt::mostly_refused, Verdict::lost, m, -1, 0, no_time, worst, trust_.refused});
  }

  void examine_innovations(int m) {
    const NisMonitor& nis = ledger_.nis(m);
    const Extreme open = nis.open(), worst = nis.worst.score > open.score ? nis.worst : open;
    if (trust_.tests_nis && worst.score > score_limit_) {
      // The newest window, open or not.
      const double newest = open.score > score_limit_ ? open.figure : nis.newest;
      const bool is_beyond = trust_.nis > 0 && newest > trust_.nis;
      see_({Doubt::nis, is_beyond ? Verdict::lost : Verdict::doubtful, m, -1, 0, worst.since, worst.figure,
            ratio_of(score_limit_, worst.size)});
    }
    for (const RowMonitor& row : ledger_.rows(m)) {
      if (row.used == 0) continue;
      Extreme bias = row.bias, correlation = row.correlation;
      bias.see(row.open_bias());
      correlation.see(row.open_correlation());
      Extreme long_bias = row.long_bias;
      long_bias.see(row.open_long_bias());
      const double systematic = plan_.measurements[as_size(m)].systematic[as_size(row.group)] /
                                std::sqrt((row.HPHt + row.R) / static_cast<double>(row.used));
      const auto sees_bias = [&](const Extreme& mean, double score) {
        const double limit = systematic + score / std::sqrt(mean.size);
        if (!trust_.tests_bias || std::abs(mean.figure) <= limit) return false;
        see_({Doubt::bias, Verdict::doubtful, m, row.group, row.key, mean.since, mean.figure, limit});
        return true;
      };
      if (!sees_bias(bias, score_limit_)) sees_bias(long_bias, long_limit_);
      if (!trust_.tests_correlation || correlation.score <= score_limit_) continue;
      if (const double limit = lag_of(score_limit_, correlation.size) + systematic * systematic;
          correlation.figure > limit)
        see_({Doubt::correlation, Verdict::doubtful, m, row.group, row.key, correlation.since, correlation.figure,
              limit});
    }
  }

  static std::int64_t count(const Tally& tally, Outcome outcome) { return tally.by_outcome[static_cast<int>(outcome)]; }

  const FilterPlan& plan_;
  const TrustPlan& trust_;
  const TimeHead& head_;
  const Ledger& ledger_;
  const CovarianceForm& P_;
  See& see_;
  double score_limit_ = 0;  // 0: innovations are not tested
  double long_limit_ = 0;   // of means over ten minutes
};

}  // namespace

VarianceLeft Ledger::indefinite(const CovarianceForm& P) const { return indefinite_row(P.expand(), factor_.data()); }

void Ledger::examine(const CovarianceForm& P, Time t) {
  const VarianceLeft found = indefinite(P);
  Health& health = *plan_.health.in(arena_);
  if (found.row < 0 || found.share >= health.indefinite_share) return;
  if (health.indefinite_row < 0) health.indefinite_at = t;
  health.indefinite_row = found.row;
  health.indefinite_share = found.share;
}

void Ledger::note_unresolved(int measurement, double ratio, Time t) {
  Health& health = *plan_.health.in(arena_);
  if (ratio <= health.unresolved_ratio) return;
  health.unresolved_by = measurement;
  health.unresolved_ratio = ratio;
  health.unresolved_at = t;
}

Verdict Ledger::verdict(const CovarianceForm& P) const {
  Verdict worst = is_broken() ? Verdict::lost : Verdict::ok;
  const auto see = [&](const TrustReason& reason) { worst = std::max(worst, reason.verdict); };
  Examination(plan_, arena_, *this, P, see).run();
  return worst;
}

std::size_t Ledger::reasons(const CovarianceForm& P, std::span<TrustReason> into) const {
  std::size_t count = 0;
  const auto see = [&](const TrustReason& reason) {
    if (count < into.size()) into[count] = reason;
    ++count;
  };
  Examination(plan_, arena_, *this, P, see).run();
  return count;
}

}  // namespace binnacle::internal::filter
