// SPDX-License-Identifier: Apache-2.0
#include "filter/engine.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::filter {

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

}  // namespace

Engine::Engine(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena)
    : plan_(plan),
      channels_(channels),
      arena_(arena),
      calls_(arena),
      time_(plan, channels, arena, *this),
      estimator_(plan, channels, arena, calls_),
      ledger_(plan, arena),
      log_(plan) {}

void Engine::attach(StepObserver* observer) {
  ledger_.attach(observer);
  if (observer) log_.allocate();
}

void Engine::reset() {
  time_.reset();
  ledger_.reset();
  calls_.note_book().clear();
  for (const auto* list : {&plan_.initial, &plan_.auxiliary})
    for (const auto& latest : *list) forget_latest(latest, arena_);
  calls_.set_time(no_time);
  guarded([&] { estimator_.reset(); });
}

void Engine::restored() {
  if (ledger_.observer() && started()) ledger_.observer()->restored(status().t, state(), covariance());
}

SampleView Engine::latest_of(const LatestPlan& plan) const {
  return latest(plan, channels_[as_size(plan.channel)], arena_);
}

// ---- what throws

template <class Act>
void Engine::guarded(Act&& act) {
  try {
    act();
  } catch (const Stop& stopped) {
    stop(stopped.what(), broken_reason);
  } catch (const std::exception& error) {
    stop(thrown(error.what()), thrown_reason);
  } catch (...) {
    stop(thrown("something that is no std::exception"), thrown_reason);
  }
}

std::string Engine::thrown(const char* what) const {
  const std::string who = calls_.is_under_way() ? calls_.text() : "an observer at " + time_text(status().t);
  return who + " threw: " + what;
}

void Engine::stop(const std::string& diagnosis, const char* reason) {
  calls_.leave();
  ledger_.stop(diagnosis);
  if (ledger_.has_open()) refuse(Outcome::rejected, reason);
  time_.flush(Outcome::rejected, broken_reason);
}

// ---- samples

void Engine::push_auxiliary(int auxiliary, const SampleView& sample) {
  const auto& plan = plan_.auxiliary[as_size(auxiliary)];
  keep_latest(plan, channels_[as_size(plan.channel)], sample, arena_);
}

void Engine::push_initial(int initial, const SampleView& sample) {
  if (started()) return;
  const auto& plan = plan_.initial[as_size(initial)];
  for (int i = 0; i < channels_[as_size(plan.channel)].epoch_fields; ++i)
    for (const auto& block : plan_.blocks)
      if (block.initial.channel == initial &&
          std::find(block.initial.fields.begin(), block.initial.fields.end(), i) != block.initial.fields.end() &&
          !std::isfinite(sample.fields[i]))
        return;
  keep_latest(plan, channels_[as_size(plan.channel)], sample, arena_);
}

void Engine::push_input(const SampleView& sample) {
  if (broken()) return;
  guarded([&] { time_.input(sample); });
}

void Engine::push_measurement(int measurement, const SampleView& sample) {
  const bool starts_by_itself = plan_.initial.empty() && plan_.input_channel < 0;
  if (!broken() && !started() && !starts_by_itself) {
    ledger_.count_before_start(measurement);
    return;
  }
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

void Engine::finish() {
  if (!started()) return;
  if (!broken()) guarded([&] { time_.end_input(); });
  guarded([&] { time_.flush(Outcome::unsupported, "no input up to its time"); });
}

// ---- the start

void Engine::try_start(Time t) {
  if (started() || broken() || plan_.initial.empty()) return;
  for (const auto& initial : plan_.initial) {
    const SampleView view = latest_of(initial);
    if (!view.available || (initial.max_age > 0 && t - view.t > initial.max_age)) return;
  }
  guarded([&] { start(t); });
}

void Engine::start(Time t) {
  calls_.set_time(t);
  estimator_.start();
  time_.start(t);
  estimator_.check_update(t);
  if (ledger_.observer()) ledger_.observer()->started(t, state(), covariance());
}

// ---- a step

void Engine::step(Time t1, std::span<const InputSample> samples) {
  calls_.set_time(t1);
  estimator_.propagate(moment(), t1, samples);
  StepObserver* const observer = ledger_.observer();
  if (!observer) {
    estimator_.predict();
  } else {
    const Wants wants = observer->wants();
    log_.keep(includes(wants, Wants::step_covariance), estimator_);
    estimator_.predict();
    observer->stepped(log_.step(wants, status().t, t1, estimator_));
  }
  estimator_.advance();
}

void Engine::stepped() { estimator_.check_step(status().t); }

// ---- a sample

void Engine::refuse(Outcome outcome, const char* reason) {
  if (!ledger_.observer()) {
    ledger_.close_unobserved(outcome, reason);
    return;
  }
  UpdateRecord record;
  record.x0 = state();
  ledger_.close(outcome, reason, record);
}

bool Engine::is_withheld(const MeasurementPlan& plan, std::int64_t reached, Time t) const {
  if (plan.withhold_every > 0 && reached % plan.withhold_every == 0) return true;
  return std::any_of(plan.withheld.begin(), plan.withheld.end(),
                     [&](const TimeSpan& window) { return window.contains(t, status().start); });
}

void Engine::measure(int measurement, const SampleView& sample) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  const Tally& tally = ledger_.tally(measurement);
  calls_.set_time(sample.t);
  ledger_.reach();
  const Result seen = estimator_.linearize(plan, sample, moment());
  if (!seen) {
    estimator_.roll_back(plan);
    refuse(outcome_of(seen.refusal), seen.reason);
    return;
  }
  const double dt = tally.last_accepted == no_time ? 0.0 : seconds(sample.t - tally.last_accepted);
  const Judgement judged = estimator_.judge(plan, sample.t, dt, is_withheld(plan, tally.reached, sample.t));
  if (judged.outcome == Outcome::accepted) {
    correct(measurement, sample.t);
    return;
  }
  estimator_.roll_back(plan);
  if (ledger_.observer())
    ledger_.close(judged.outcome, judged.reason, log_.innovation(ledger_.wants(), plan, estimator_));
  else
    ledger_.close_unobserved(judged.outcome, judged.reason);
  if (judged.outcome == Outcome::gated && ledger_.is_recovery_due(measurement)) open_covariance(measurement, sample.t);
}

void Engine::correct(int measurement, Time t) {
  const auto& plan = plan_.measurements[as_size(measurement)];
  const Wants wants = ledger_.wants();
  if (ledger_.observer()) log_.keep(includes(wants, Wants::update_covariance), estimator_);
  estimator_.correct(plan);
  const SampleRows& rows = estimator_.rows();
  ledger_.count_left_out(measurement, rows.left_out, rows.left_out_keys.data(), rows.left_out_groups.data());
  if (ledger_.observer())
    ledger_.close(Outcome::accepted, "", log_.update(wants, plan, estimator_));
  else
    ledger_.close_unobserved(Outcome::accepted, "", rows.m, rows.nis);
  estimator_.learn(plan);
  estimator_.check_update(t);
}

void Engine::open_covariance(int measurement, Time t) {
  const Wants wants = ledger_.wants();
  if (ledger_.observer()) log_.keep(includes(wants, Wants::update_covariance), estimator_);
  estimator_.inflate(plan_.measurements[as_size(measurement)]);
  if (ledger_.observer()) ledger_.observer()->inflated(log_.inflation(wants, measurement, t, estimator_));
}

bool Engine::write_estimates(SampleWriter& slot) {
  slot.t = status().t;
  slot.t0 = no_time;
  calls_.set_time(slot.t);
  guarded([&] { estimator_.write(slot); });
  return !broken();
}

}  // namespace binnacle::filter
