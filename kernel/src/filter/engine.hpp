// SPDX-License-Identifier: Apache-2.0
// One run of one composed filter: the time line says when, the estimator what, the ledger what became of it. Everything
// that outlives a call lies in the arena, so that a snapshot is a copy of the arena's bytes.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "binnacle/sample.hpp"
#include "binnacle/step_log.hpp"
#include "filter/estimator.hpp"
#include "filter/ledger.hpp"
#include "filter/model_calls.hpp"
#include "filter/step_observers.hpp"
#include "filter/time_line.hpp"

namespace binnacle::internal::filter {

/// What throws inside, or gives what may not be, stops the filter with a diagnosis that names it; nothing leaves.
class Engine final : private TimeLine::Work {
 public:
  /// plan, channels and arena must outlive the engine. Allocates its workspace here and nothing afterwards.
  Engine(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena);
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// Initialises the arena for a new run.
  void reset();
  // These allocate.
  void attach(StepObserver* observer) { attach({observer, observers_.of_section()}); }
  void attach_section(StepObserver* observer) { attach({observers_.of_run(), observer}); }
  /// The arena was overwritten by a snapshot.
  void restored();
  /// By one of its own history.
  void rewound();

  /// Samples as their channel lays them out. What is not subscribed to must not be handed in.
  void push_input(const SampleView& sample);
  /// Its time is beyond the filter's history.
  void refuse_late(int measurement, Time t);
  /// late: how much later it came than what is newer.
  void push_measurement(int measurement, const SampleView& sample, Time late = 0);
  void push_auxiliary(int auxiliary, const SampleView& sample);
  void push_initial(int initial, const SampleView& sample);
  /// The end of the run: what still waits for input gets its outcome.
  void finish();
  /// Starts the filter at t when all its initial values are there; called once all samples of the instant are in.
  void try_start(Time t);

  const TimeHead& status() const { return time_.head(); }
  bool started() const { return time_.is_started(); }
  Verdict verdict() const { return ledger_.verdict(estimator_.form()); }
  std::size_t reasons(std::span<TrustReason> into) const { return ledger_.reasons(estimator_.form(), into); }
  bool has_started() const { return time_.head().starts > 0; }
  /// Whether the numbers of its state are ones to go on from; of one that is at work.
  bool is_sound() const { return broken() || !started() || estimator_.is_sound(); }
  bool broken() const { return ledger_.is_broken(); }
  const double* state() const { return estimator_.state(); }
  ConstMatrixView covariance() const { return estimator_.covariance(); }
  const Ledger& ledger() const { return ledger_; }
  const ModelCalls& calls() const { return calls_; }
  ModelCalls& calls() { return calls_; }
  const FilterPlan& plan() const { return plan_; }
  /// Estimates as a sample of the filter's own channel: outputs of all blocks, P in their error dof. False: it could not be
  /// written, and the filter stops.
  bool write_estimates(SampleWriter& slot) { return write_estimates(slot, status().t, state(), covariance()); }
  bool write_estimates(SampleWriter& slot, Time t, const double* x, ConstMatrixView P);

 private:
  void start(Time t) override;
  void step(Time t1, std::span<const InputSample> samples) override;
  void stepped() override;
  void measure(int measurement, const SampleView& sample) override;
  void refuse(Outcome outcome, const char* reason) override;
  void wait() override { ledger_.wait(); }
  void resume(int measurement, Time t) override { ledger_.reopen(measurement, t); }

  template <class Act>
  void guarded(Act&& act);
  std::string thrown(const std::string& what) const;
  void stop(const std::string& diagnosis, const char* reason);

  Driving moment() const { return {time_.head().t, time_.driving_rates(), time_.head().bridged != 0}; }
  bool can_start(Time t, bool anew) const;
  bool is_withheld(const MeasurementPlan& plan, std::int64_t reached, Time t) const;
  void iterate(int measurement, const SampleView& sample);
  void look_for_lost_digits(int measurement, Time t);
  void correct(int measurement, Time t);
  void open_biased(int measurement, Time t);
  void keep_open(int measurement, Time t);
  void unlearn(int measurement, Time t);
  Result linearize(int measurement, const SampleView& sample, bool follows);
  template <class Open>
  void recover(int measurement, Time t, Belief belief, bool is_refused, Open&& open);
  void ask_restart(int measurement, Time t);
  bool follow();
  void note_opening(int measurement, Time t);
  void inflate(int measurement, Time t);
  void keep_latest(const LatestPlan& plan, const SampleView& sample);

  void attach(StepObservers observers);

  // Records for the observer
  bool is_wanted(Wants part) const { return includes(wants_, part); }
  /// Before x or P changes, by a correction or an inflation: keeps x, and P where it is wanted.
  void keep_before();
  StepRecord step_record(Time t1);
  /// Of a sample that was linearized.
  UpdateRecord innovation_record(const MeasurementPlan& measurement);
  /// Of one that was accepted and has corrected.
  UpdateRecord update_record(const MeasurementPlan& measurement);
  InflationRecord inflation_record(InflationRecord record);
  MatrixView square(std::vector<double>& matrix) const { return {matrix.data(), plan_.n, plan_.n, plan_.n}; }

  const FilterPlan& plan_;
  const std::vector<ChannelPlan>& channels_;
  std::byte* arena_;
  ModelCalls calls_;
  TimeLine time_;
  Estimator estimator_;
  Ledger ledger_;
  StepObservers observers_;
  Wants wants_ = Wants::nothing;  // of the step or sample at work
  std::vector<double> x_before_, P_before_, Phi_, Qd_, H_, reset_, variances_;
};

}  // namespace binnacle::internal::filter
