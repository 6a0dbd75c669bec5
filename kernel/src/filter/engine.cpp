// SPDX-License-Identifier: Apache-2.0
#include "filter/engine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace binnacle::internal::filter {

namespace {

constexpr const char* broken_reason = "the filter is broken";
constexpr const char* thrown_reason = "a plugin threw";

Outcome outcome_of(Refusal refusal) {
  switch (refusal) {
    case Refusal::unsupported: return Outcome::unsupported;
    case Refusal::invalid: return Outcome::invalid;
    default: return Outcome::rejected;
  }
}

/// Recoveries of a measurement, each soon after the one before, that did not help: it starts anew.
constexpr int most_recoveries_in_vain = 3;

/// Asks the ledger about rows of the sample at work.
struct LockedOut {
  Ledger& ledger;
  int measurement;
  Time t;
  bool repeats;
  bool is_asked = false;
  Belief belief = Belief::none;
  LockOutTest test() {
    return {this, [](void* self, const SampleRows& rows, unsigned char* marked) {
              auto& its = *static_cast<LockedOut*>(self);
              if (its.repeats && !std::exchange(its.is_asked, true)) its.ledger.count_repeat(its.measurement, its.t);
              if (its.repeats) return false;
              its.belief = its.ledger.is_locked_out(its.measurement, rows.offered(), marked);
              return its.belief != Belief::none;
            }};
  }
};

}  // namespace

Engine::Engine(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena)
    : plan_(plan),
      channels_(channels),
      arena_(arena),
      time_(plan, channels, arena, *this),
      estimator_(plan, channels, arena, calls_),
      ledger_(plan, arena),
      variances_(as_size(plan.n)) {}

void Engine::reset() {
  time_.reset();
  ledger_.reset();
  calls_.note_book.clear();
  for (const auto* list : {&plan_.initial, &plan_.auxiliary})
    for (const auto& latest : *list) {
      *latest.head.in(arena_) = SampleHead{};
      std::fill_n(latest.data.in(arena_), latest.data.count, std::numeric_limits<double>::quiet_NaN());
    }
  calls_.set_time(no_time);
  guarded([&] { estimator_.reset(); });
}

void Engine::restored() {
  if (ledger_.observer() && started()) ledger_.observer()->restored(status().t, state(), covariance());
}

void Engine::rewound() {
  if (ledger_.observer()) ledger_.observer()->rewound(started() ? status().t : no_time);
}

void Engine::keep_latest(const LatestPlan& plan, const SampleView& sample) {
  *plan.head.in(arena_) = pack(channels_[as_size(plan.channel)], sample, plan.data.in(arena_));
}

template <class Act>
void Engine::guarded(Act&& act) {
  try {
    act();
  } catch (const Stop& stopped) {
    stop(stopped.what(), broken_reason);
  } catch (...) {
    stop(thrown(what_was_thrown()), thrown_reason);
  }
}

std::string Engine::thrown(const std::string& what) const {
  const std::string who = calls_.call() ? calls_.place_text() : "an observer at " + time_text(status().t);
  return who + " threw: " + what;
}

void Engine::stop(const std::string& diagnosis, const char* reason) {
  calls_.leave();
  ledger_.stop(diagnosis);
  if (ledger_.has_open()) refuse(Outcome::rejected, reason);
  time_.flush(Outcome::rejected, broken_reason);
}

void Engine::push_auxiliary(int auxiliary, const SampleView& sample) {
  keep_latest(plan_.auxiliary[as_size(auxiliary)], sample);
}

void Engine::push_initial(int initial, const SampleView& sample) {
  const LatestPlan& plan = plan_.initial[as_size(initial)];
  if (has_started() && !plan.is_of_restart) return;
  const bool is_finite = std::ranges::all_of(plan_.blocks, [&](const BlockPlan& block) {
    const InitialPlan& from = block.start(has_started());
    return from.channel != initial ||
           std::ranges::all_of(from.fields, [&](int field) { return std::isfinite(sample.fields[field]); });
  });
  if (is_finite) keep_latest(plan, sample);
}

void Engine::push_input(const SampleView& sample) {
  if (broken()) return;
  guarded([&] { time_.input(sample); });
}

void Engine::push_measurement(int measurement, const SampleView& sample, Time late) {
  const bool starts_by_itself = plan_.initial.empty() && plan_.input_channel < 0;
  if (!broken() && !started() && !starts_by_itself) {
    ledger_.count_before_start(measurement);
    return;
  }
  if (late > 0) ledger_.count_replayed(measurement, late);
  guarded([&] {
    ledger_.open(measurement, sample.t);
    if (broken()) {
      refuse(Outcome::rejected, broken_reason);
      return;
    }
    if (!started()) start(sample.t);
    time_.offer(measurement, sample);
  });
}

void Engine::refuse_late(int measurement, Time t) {
  if (!started()) return ledger_.count_before_start(measurement);
  guarded([&] {
    ledger_.open(measurement, t);
    refuse(Outcome::late, "older than the filter's history");
  });
}

void Engine::finish() {
  if (!has_started()) return;
  if (!broken()) guarded([&] { time_.end_input(); });
  guarded([&] { time_.flush(Outcome::unsupported, "no input up to its time"); });
}

void Engine::try_start(Time t) {
  if (broken() || plan_.initial.empty() || (started() && !time_.is_restart_due(t))) return;
  if (can_start(t, has_started())) guarded([&] { start(t); });
}

/// All channels that it needs for it have a sample, for a further start a fresh and new one.
bool Engine::can_start(Time t, bool anew) const {
  constexpr Time fresh = nanoseconds_per_second;
  return std::ranges::all_of(plan_.initial, [&](const LatestPlan& initial) {
    if (!(anew ? initial.is_of_restart : initial.is_of_start)) return true;
    const Time newest = initial.head.in(arena_)->t, max_age = initial.max_age == 0 && anew ? fresh : initial.max_age;
    if (newest == no_time || (max_age > 0 && t - newest > max_age)) return false;
    return !anew || newest > time_.head().last_start;
  });
}

void Engine::start(Time t) {
  calls_.set_time(t);
  const bool anew = has_started();
  if (anew) {
    time_.flush(Outcome::unsupported, "the filter started anew");
    ledger_.forget_refusals();
    estimator_.reset();
  }
  estimator_.start(anew);
  time_.start(t);
  for (int m = 0; m < static_cast<int>(plan_.measurements.size()); ++m) ledger_.settle(m, t, estimator_.form());
  estimator_.check_update(t);
  if (ledger_.observer()) ledger_.observer()->started(t, state(), covariance());
}

/// Along the observer's path, if it has one.
bool Engine::follow() {
  const double* const x = ledger_.observer() ? ledger_.observer()->nominal() : nullptr;
  if (x) estimator_.put(x);
  return x;
}

void Engine::step(Time t1, std::span<const InputSample> samples) {
  calls_.set_time(t1);
  const bool follows = follow();
  estimator_.propagate(moment(), t1, samples, follows);
  wants_ = ledger_.wants();
  if (ledger_.observer() && is_wanted(Wants::step_covariance)) square(P_before_).as() = covariance().as();
  if (!follows) estimator_.predict(t1);
  if (ledger_.observer()) ledger_.observer()->stepped(step_record(t1));
  estimator_.advance();
}

void Engine::stepped() {
  constexpr std::int64_t now_and_then = 1024;
  estimator_.check_step(status().t);
  if (status().steps % now_and_then == 0) ledger_.examine(estimator_.form(), status().t);
}

/// Before the update.
void Engine::look_for_lost_digits(int measurement, Time t) {
  if (plan_.covariance_kind != CovarianceKind::joseph) return;
  const SampleRows& rows = estimator_.rows();
  for (int i = 0; i < rows.m; ++i) {
    const double seen = rows.HPHt[i * (rows.m_max + 1)], noise = rows.R[i * (rows.m_max + 1)];
    if (seen >= unresolved_from * noise && noise > 0) ledger_.note_unresolved(measurement, seen / noise, t);
  }
}

void Engine::refuse(Outcome outcome, const char* reason) {
  UpdateRecord record;
  record.x0 = state();
  ledger_.close(outcome, reason, record);
}

bool Engine::is_withheld(const MeasurementPlan& plan, std::int64_t reached, Time t) const {
  if (plan.withhold_every > 0 && reached % plan.withhold_every == 0) return true;
  return std::ranges::any_of(plan.withheld, [&](const TimeSpan& window) { return window.contains(t, status().start); });
}

void Engine::measure(int measurement, const SampleView& sample) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  const Tally& tally = ledger_.tally(measurement);
  calls_.set_time(sample.t);
  wants_ = ledger_.wants();
  ledger_.reach();
  // Only what a recovery may believe is looked at.
  const bool repeats = plan.recover_after > 0 && ledger_.repeats(measurement, sample, channels_[as_size(plan.channel)]);
  if (repeats && tally.repeats.count >= plan.recover_after) {
    ledger_.count_repeat(measurement, sample.t);
    refuse(Outcome::gated, "it repeats refused samples to the bit");
    return;
  }
  const bool follows = follow();
  const Result seen = linearize(measurement, sample, follows);
  if (estimator_.was_linearized_instead()) ledger_.count_linearized(measurement);
  if (!seen) {
    estimator_.roll_back(plan);
    refuse(outcome_of(seen.refusal), seen.reason);
    return;
  }
  const double dt = tally.last_accepted == no_time ? 0.0 : seconds(sample.t - tally.last_accepted);
  const bool withheld = follows || is_withheld(plan, tally.reached, sample.t);
  LockedOut locked_out{ledger_, measurement, sample.t, repeats};
  Judgement judged = estimator_.judge(plan, sample.t, dt, withheld, locked_out.test());
  const SampleRows& rows = estimator_.rows();
  const bool is_opened = judged.is_locked_out && locked_out.belief != Belief::by_scatter;
  if (judged.is_locked_out) {
    // Its rows anew: some may be gone already.
    if (is_opened)
      recover(measurement, sample.t, locked_out.belief, true, [&] { return estimator_.open(plan, judged.marked); });
    estimator_.roll_back(plan);
    if (const Result again = linearize(measurement, sample, false); !again) {
      estimator_.roll_back(plan);
      refuse(outcome_of(again.refusal), again.reason);
      return;
    }
    judged = estimator_.judge(plan, sample.t, dt, withheld);
  }
  if (judged.outcome == Outcome::accepted) {
    if (plan.update.type == UpdatePlan::Type::iterated) iterate(measurement, sample);
    correct(measurement, sample.t);
    if (is_opened) keep_open(measurement, sample.t);
    return;
  }
  estimator_.roll_back(plan);
  if (judged.outcome == Outcome::withheld) {
    ledger_.end_silence(measurement, sample.t, estimator_.form());
    ledger_.settle(measurement, sample.t, estimator_.form());
  }
  if (judged.outcome == Outcome::gated && !repeats) {
    ledger_.refuse(rows.refused());
    ledger_.refuse(rows.left_out_rows(rows.removed));
  }
  ledger_.close(judged.outcome, judged.reason, innovation_record(plan));
  if (judged.outcome == Outcome::gated && !repeats && ledger_.is_inflation_due(measurement))
    inflate(measurement, sample.t);
}

Result Engine::linearize(int measurement, const SampleView& sample, bool follows) {
  SampleRows& rows = estimator_.rows();
  const Result seen = estimator_.linearize(plan_.measurements[as_size(measurement)], sample, moment(), follows);
  if (seen) ledger_.widen_noise(measurement, rows.offered(), rows.square(rows.R_nominal.data()));
  return seen;
}

void Engine::iterate(int measurement, const SampleView& sample) {
  const auto [iterations, has_converged] =
      estimator_.iterate(plan_.measurements[as_size(measurement)], sample, moment());
  ledger_.count_iterations(measurement, iterations, has_converged);
}

void Engine::correct(int measurement, Time t) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  keep_before();
  ledger_.end_silence(measurement, t, estimator_.form());
  look_for_lost_digits(measurement, t);
  estimator_.correct(plan);
  ledger_.settle(measurement, t, estimator_.form());
  const SampleRows& rows = estimator_.rows();
  const bool is_biased = ledger_.use(rows.used(plan.widens ? rows.post_fit.data() : nullptr), rows.nis);
  if (rows.left_out > 0) ledger_.leave_out(rows.left_out_rows(rows.left_out));
  ledger_.close(Outcome::accepted, "", update_record(plan));
  estimator_.learn(plan);
  estimator_.check_update(t);
  if (is_biased) open_biased(measurement, t);
}

/// By rows that pass, and whose mean says that the state is wrong.
void Engine::open_biased(int measurement, Time t) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  SampleRows& rows = estimator_.rows();
  estimator_.project(plan);
  const Belief belief =
      ledger_.is_biased(measurement, rows.offered(), t, rows.biased.data(), rows.mean_z.data(), rows.mean_count.data());
  if (belief == Belief::none) return;
  recover(measurement, t, belief, false, [&] { return estimator_.open_by_mean(plan); });
}

/// What was corrected after P was opened was far off.
void Engine::keep_open(int measurement, Time t) {
  keep_before();
  estimator_.keep_open();
  note_opening(measurement, t);
}

/// Most of what came contradicts the state: what it has learnt meanwhile is not worth much.
void Engine::unlearn(int measurement, Time t) {
  keep_before();
  estimator_.unlearn(variances_.data());
  if (ledger_.observer())
    ledger_.observer()->inflated(inflation_record({measurement, t, variances_.data(), nullptr, {}, {}}));
}

/// A state that is wrong starts anew at once where what it would start from contradicts it, by P before it is opened.
template <class Open>
void Engine::recover(int measurement, Time t, Belief belief, bool is_refused, Open&& open) {
  const bool is_contradicted = belief == Belief::by_votes && can_start(t, true) && estimator_.is_contradicted();
  if (is_contradicted) ask_restart(measurement, t);
  const double alone = is_refused ? estimator_.unconfirmed(is_contradicted || ledger_.is_confirmed()) : 0.0;
  keep_before();
  const bool is_open = open();
  if (is_open) note_opening(measurement, t);
  if (belief == Belief::by_votes) unlearn(measurement, t);
  const bool starts_anew = ledger_.count_recovery(measurement, t) >= most_recoveries_in_vain &&
                           std::ranges::any_of(plan_.initial, &LatestPlan::is_of_restart);
  if (starts_anew) ask_restart(measurement, t);
  if (alone > 0 && (is_open || starts_anew)) ledger_.count_unconfirmed(measurement, alone);
}

void Engine::ask_restart(int measurement, Time t) {
  time_.ask_restart(t + plan_.measurements[as_size(measurement)].recover_against);
}

void Engine::note_opening(int measurement, Time t) {
  if (ledger_.observer())
    ledger_.observer()->inflated(inflation_record({measurement, t, nullptr, estimator_.opened(), {}, {}}));
}

void Engine::inflate(int measurement, Time t) {
  keep_before();
  estimator_.inflate(plan_.measurements[as_size(measurement)]);
  ledger_.count_recovery(measurement, t);
  if (!ledger_.observer()) return;
  std::fill(variances_.begin(), variances_.end(), 0.0);
  for (const auto& inflation : plan_.measurements[as_size(measurement)].inflations)
    variances_[as_size(inflation.row)] += inflation.variance;
  ledger_.observer()->inflated(inflation_record({measurement, t, variances_.data(), nullptr, {}, {}}));
}

bool Engine::write_estimates(SampleWriter& slot, Time t, const double* x, ConstMatrixView P) {
  slot.t = t;
  slot.t0 = no_time;
  calls_.set_time(t);
  guarded([&] { estimator_.write(slot, x, P); });
  return !broken();
}

void Engine::attach(StepObservers observers) {
  observers_ = observers;
  ledger_.attach(observers_.any());
  if (!ledger_.observer()) return;
  const auto n = as_size(plan_.n);
  x_before_.resize(as_size(plan_.stored_size));
  for (auto* matrix : {&P_before_, &Phi_, &Qd_, &reset_}) matrix->resize(n * n);
  H_.resize(as_size(plan_.max_rows) * n);
}

void Engine::keep_before() {
  if (!ledger_.observer()) return;
  std::copy_n(state(), plan_.stored_size, x_before_.data());
  if (is_wanted(Wants::update_covariance)) square(P_before_).as() = covariance().as();
}

StepRecord Engine::step_record(Time t1) {
  StepRecord record{status().t, t1, state(), estimator_.x_plus(), {}, {}, {}, {}};
  if (is_wanted(Wants::step_covariance)) std::tie(record.P0, record.P1) = std::pair(square(P_before_), covariance());
  if (is_wanted(Wants::transition)) {
    record.Phi = square(Phi_);
    record.Qd = square(Qd_);
    expand_transition(plan_.transition, estimator_.phi(), square(Phi_));
    expand_noise(plan_.transition, estimator_.noise(), square(Qd_));
  }
  return record;
}

UpdateRecord Engine::innovation_record(const MeasurementPlan& measurement) {
  const SampleRows& rows = estimator_.rows();
  UpdateRecord record;
  record.rows = rows.m;
  record.nis = rows.nis;
  if (!ledger_.observer()) return record;
  record.x0 = state();
  record.row_keys = rows.keys.data();
  record.row_groups = rows.groups.data();
  record.left_out = rows.left_out;
  record.left_out_keys = rows.left_out_keys.data();
  record.residual = rows.innovation;
  record.S = rows.square(rows.innovation_S);
  record.update_residual = rows.r;
  record.update_S = rows.square(rows.S);
  record.R = rows.square(rows.R);
  if (!is_wanted(Wants::jacobian)) return record;
  record.H = {H_.data(), rows.m, plan_.n, rows.m};
  std::fill_n(H_.data(), rows.m * plan_.n, 0.0);
  const auto& columns = measurement.columns;
  for (std::size_t c = 0; c < columns.size(); ++c)
    std::copy_n(rows.H + c * as_size(rows.m_max), rows.m, H_.data() + as_size(columns[c] * rows.m));
  return record;
}

UpdateRecord Engine::update_record(const MeasurementPlan& measurement) {
  const SampleRows& rows = estimator_.rows();
  UpdateRecord record = innovation_record(measurement);
  record.K = {rows.K, plan_.n, rows.m, padded(plan_.n)};
  record.delta = rows.delta.data();
  record.x0 = x_before_.data();
  record.x1 = state();
  if (is_wanted(Wants::update_covariance)) std::tie(record.P0, record.P1) = std::pair(square(P_before_), covariance());
  if (is_wanted(Wants::reset) && estimator_.has_reset()) {
    record.reset = square(reset_);
    estimator_.expand_reset(square(reset_));
  }
  return record;
}

InflationRecord Engine::inflation_record(InflationRecord record) {
  if (is_wanted(Wants::update_covariance)) std::tie(record.P0, record.P1) = std::pair(square(P_before_), covariance());
  return record;
}

}  // namespace binnacle::internal::filter
