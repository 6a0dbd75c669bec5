// SPDX-License-Identifier: Apache-2.0
// The verdict: what a filter's monitors say against its estimates.
#include <algorithm>
#include <cmath>

#include <boost/math/distributions/normal.hpp>

#include "filter/ledger.hpp"

namespace binnacle::internal::filter {

namespace {

constexpr double ten_minutes = 600;

/// Goes through the monitors of one filter and tells `see` each reason.
template <class See>
class Examination {
 public:
  Examination(const FilterPlan& plan, const std::byte* arena, const Ledger& ledger, See& see)
      : plan_(plan), trust_(plan.trust), head_(*plan.head.in(arena)), ledger_(ledger), see_(see) {}

  void run() {
    if (head_.started == 0) return;
    if (is_unaided()) see_({.doubt = Doubt::unaided, .verdict = Verdict::lost});
    score_limit_ = score_limit();
    for (int m = 0; m < static_cast<int>(plan_.measurements.size()); ++m)
      if (plan_.measurements[as_size(m)].is_watched) examine(m);
    if (trust_.hole > 0 && head_.longest_hole > trust_.hole)
      see_({.doubt = Doubt::bridged,
            .since = head_.longest_hole_at,
            .figure = seconds(head_.longest_hole),
            .limit = seconds(trust_.hole)});
    if (trust_.frozen > 0 && head_.longest_repeat > trust_.frozen)
      see_({.doubt = Doubt::frozen,
            .since = head_.longest_repeat_at,
            .figure = seconds(head_.longest_repeat),
            .limit = seconds(trust_.frozen)});
  }

 private:
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

  /// The tests of innovations share the probability of a false alarm (Bonferroni): the score which a right filter passes
  /// with a probability of 1 − false_alarm · (its run in units of ten minutes, at least one) / tests.
  double score_limit() const {
    std::int64_t tests = 0;
    for (int m = 0; m < static_cast<int>(plan_.measurements.size()); ++m) {
      if (!plan_.measurements[as_size(m)].is_watched) continue;
      if (trust_.tests_nis) tests += ledger_.nis(m).windows;
      // The test of a bias has two sides.
      for (const RowMonitor& row : ledger_.rows(m))
        tests += row.windows * (2 * trust_.tests_bias + trust_.tests_correlation);
    }
    if (tests == 0 || trust_.false_alarm <= 0) return 0;
    const double runs = std::max(1.0, seconds(head_.t - head_.start) / ten_minutes);
    const double probability = std::min(0.1, trust_.false_alarm * runs / static_cast<double>(tests));
    return boost::math::quantile(boost::math::complement(boost::math::normal(), probability));
  }

  void examine(int m) {
    const Tally& tally = ledger_.tally(m);
    const bool by_sample = plan_.measurements[as_size(m)].gate_unit == GateUnit::sample;
    const std::int64_t accepted = count(tally, Outcome::accepted), gated = count(tally, Outcome::gated);
    const std::int64_t refused = gated + count(tally, Outcome::invalid) + count(tally, Outcome::rejected);
    if (trust_.after > 0 && accepted == 0 && refused >= trust_.after) {
      see_({Doubt::never_accepted, Verdict::lost, m, -1, 0, no_time, double(refused), double(trust_.after)});
      return;
    }
    examine_lock_out(m, tally, by_sample);
    examine_share(m);
    if (tally.recoveries > 0)
      see_({Doubt::recovered, Verdict::doubtful, m, -1, 0, no_time, double(tally.recoveries), 0});
    examine_innovations(m);
  }

  /// All that is refused together is one reason; rows one by one where others pass.
  void examine_lock_out(int m, const Tally& tally, bool by_sample) {
    if (trust_.after == 0 || plan_.measurements[as_size(m)].recover_after == 0) return;
    if (tally.gated.count >= trust_.after) {
      see_(locked_out(m, Verdict::lost, -1, 0, tally.gated));
      return;
    }
    if (by_sample) {
      if (tally.gated.longest >= trust_.after) see_(was_locked_out(m, -1, 0, tally.gated));
      return;
    }
    const auto is_out = [&](const RowMonitor& row) { return row.streak.count >= trust_.after; };
    std::int64_t out = 0, all = 0;
    for (const RowMonitor& row : ledger_.rows(m)) {
      all += row.is_in_use;
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
    return {Doubt::was_locked_out,  Verdict::doubtful,   m, group, key, streak.longest_since,
            double(streak.longest), double(trust_.after)};
  }

  void examine_share(int m) {
    constexpr std::int64_t least = 10;
    std::int64_t used = 0, refused = 0;
    for (const RowMonitor& row : ledger_.rows(m)) {
      used += row.used;
      refused += row.refused;
    }
    const double share = double(refused) / double(std::max<std::int64_t>(1, used + refused));
    if (trust_.refused > 0 && refused >= least && share > trust_.refused)
      see_({Doubt::mostly_refused, Verdict::lost, m, -1, 0, no_time, share, trust_.refused});
  }

  void examine_innovations(int m) {
    const NisMonitor& nis = ledger_.nis(m);
    if (score_limit_ <= 0) return;
    if (trust_.tests_nis && nis.worst.score > score_limit_) {
      const bool is_beyond = trust_.nis > 0 && nis.newest > trust_.nis;
      see_({Doubt::nis, is_beyond ? Verdict::lost : Verdict::doubtful, m, -1, 0, nis.worst.since, nis.worst.figure,
            ratio_of(score_limit_, nis.worst.size)});
    }
    for (const RowMonitor& row : ledger_.rows(m)) {
      const auto see_extreme = [&](Doubt doubt, const Extreme& extreme) {
        if (extreme.score > score_limit_)
          see_({doubt, Verdict::doubtful, m, row.group, row.key, extreme.since, extreme.figure,
                score_limit_ / std::sqrt(extreme.size)});
      };
      if (trust_.tests_bias) see_extreme(Doubt::bias, row.bias);
      if (trust_.tests_correlation) see_extreme(Doubt::correlation, row.correlation);
    }
  }

  static std::int64_t count(const Tally& tally, Outcome outcome) { return tally.by_outcome[static_cast<int>(outcome)]; }

  const FilterPlan& plan_;
  const TrustPlan& trust_;
  const TimeHead& head_;
  const Ledger& ledger_;
  See& see_;
  double score_limit_ = 0;  // 0: innovations are not tested
};

}  // namespace

Verdict Ledger::verdict() const {
  Verdict worst = is_broken() ? Verdict::lost : Verdict::ok;
  const auto see = [&](const TrustReason& reason) { worst = std::max(worst, reason.verdict); };
  Examination(plan_, arena_, *this, see).run();
  return worst;
}

std::size_t Ledger::reasons(std::span<TrustReason> into) const {
  std::size_t count = 0;
  const auto see = [&](const TrustReason& reason) {
    if (count < into.size()) into[count] = reason;
    ++count;
  };
  Examination(plan_, arena_, *this, see).run();
  return count;
}

}  // namespace binnacle::internal::filter
