// SPDX-License-Identifier: Apache-2.0
// Scores one filter of a run: errors against reference channels and against withheld samples.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bias_effects.hpp"
#include "binnacle/session.hpp"
#include "binnacle/state_block.hpp"
#include "binnacle/step_log.hpp"
#include "gate_watch.hpp"
#include "implied_state.hpp"
#include "jump_watch.hpp"
#include "plan.hpp"
#include "score/run.hpp"
#include "segments.hpp"
#include "series.hpp"
#include "start_watch.hpp"
#include "state_nees.hpp"

namespace binnacle::score {

/// What a metric can be of: an error or a norm, or for its NEES a block or the whole state.
struct Scored {
  std::string name;  // "position.horizontal", "position"
  std::string unit;  // SI
  std::string display_unit;
  int index = 0;  // Metric::subject
  NeesOf nees_of = NeesOf::component;
  bool has_sigma = false;
  bool has_nees = false;
};

/// Follows one filter. A reference between two steps is compared with the estimate interpolated on the manifold from
/// the a-posteriori state at the step's begin to the a-priori one at its end, so that scoring never changes the run.
class FilterScore : public StepObserver {
 public:
  FilterScore(const ScorePlan& plan, int filter);
  /// Of a filter that is smoothed: its own measurements are not judged, and reference(), stepped() and withheld() are called
  /// after the run, in order of time.
  FilterScore(const ScorePlan& plan, const SmoothingPlan& smoothing);
  FilterScore(const FilterScore&) = delete;
  FilterScore& operator=(const FilterScore&) = delete;

  /// Before the run. `next` sees the same step log; null: nobody. The session outlives all use but figures once finish()
  /// was called.
  void attach(Session& session, StepObserver* next);
  /// No NEES and no references but what watch() is given from here on, or what sigmas are kept of: there is to be no summary.
  void watch_only();
  /// Before the run: what the metric needs beyond the errors is kept too.
  void watch(const Metric& metric);
  /// Before the run: the 1-σ of every error is kept too.
  void keep_sigmas();

  // ---- during the run
  void reference(int channel, const SampleView& sample);
  Wants wants() const override {
    Wants all = next_ ? next_->wants() : Wants::nothing;
    if (effects_) all = all | effects_->wants() | jumps_.wants();
    if (!pending_.empty()) all = all | Wants::step_covariance;
    if (!implied_states_.empty()) all = all | Wants::jacobian | Wants::update_covariance;
    return all;
  }
  void started(Time t, const double* x, ConstMatrixView P) override;
  void rewound(Time t) override {
    if (next_) next_->rewound(t);
    if (effects_) effects_->rewound();
    seen_until_ = newest_;
  }
  void restored(Time t, const double* x, ConstMatrixView P) override {
    if (next_) next_->restored(t, x, P);
  }
  void inflated(const InflationRecord& record) override {
    ++changes_;
    if (next_) next_->inflated(record);
    jumps_.inflated(record);
  }
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;
  /// Of the estimate, so far: another number means another estimate.
  std::int64_t changes() const { return changes_; }
  void withheld(const UpdateRecord& record) { score_withheld(record); }
  /// Whether a sample of the channel is a reference of it.
  bool refers_to(int channel) const;
  /// For checkpoints, of a filter that is attached.
  void exchange(StateBytes& bytes);
  /// What still waits for the filter's next step is scored with the last estimate.
  void finish();

  /// Implied states and their 1-σ; NaN where there is none of this very time.
  std::vector<RecordColumn> implied_state_columns() const;
  void latest_implied_states(Time t, double* values);
  /// What noise estimators make of R, as 1-σ by group of rows; the newest values, NaN before the first.
  std::vector<RecordColumn> noise_columns() const;
  void latest_noise(double* values) const;

  /// Null where nothing is watched.
  const BiasEffects* effects() const { return effects_.get(); }
  const JumpWatch& jumps() const { return jumps_; }

  // ---- figures (filter_figures.cpp)
  std::vector<Scored> scored() const;
  /// Positions whose segments can be scored, and the attitudes that can go with them; Metric::subject is an index.
  struct Track {
    std::string name;  // "position.segments"
    int position = 0;  // reference
    std::vector<std::string> attitudes;
    int attitude = 0;  // reference of the first, or of the one that "evaluate" names
  };
  std::vector<Track> tracks() const;
  nlohmann::ordered_json summary() const;
  MetricValue value(const Metric& metric) const;
  /// RunObserver::scored() for everything there is.
  void show_errors(RunObserver& observer) const;
  /// All series that stand under "reference", once per name: channels first, then what was withheld.
  std::vector<const Series*> reference_series() const;

  /// A warning for each span of "evaluate" that no sample of this filter's references falls into (B121), and for an
  /// 'after' that leaves out nothing, long before the run (B129).
  void warn_of_spans(Diagnostics& warnings) const;
  /// For each metric of segments that has none, with the reason (B125).
  void warn_of_no_segments(const Metric& metric, Diagnostics& warnings) const;
  Time start() const { return session_ ? session_->start_time(FilterId{filter_}) : start_; }
  void set_start(Time t) { start_ = t; }

 private:
  struct Reference {
    const ReferencePlan* plan = nullptr;
    const BlockInfo* block = nullptr;  // or the implied state's
    std::string name;                  // of it
    bool is_whole = false;             // all outputs are given: errors by ⊟
    std::vector<Series> series;
    std::vector<int> output_series;  // per output: index in series, −1
    Series nees;
    std::vector<std::vector<double>> sigmas;  // per series, beside its values; empty when nobody asked for them
    int state_part = -1;                      // of state_nees_; −1: not in it
    bool has_nees = true;
    bool is_watched = true;
  };
  struct Pending {
    int reference = 0;
    Time t = no_time;
    std::vector<double> values;
  };
  /// What a metric of segments was watched for.
  struct WatchedTrack {
    int subject = 0;
    int position = 0, attitude = 0;  // references
    SegmentTrack track;
  };
  const SegmentTrack& track_of(const Metric& metric) const;
  void watch_track(int subject);
  void take_poses(const Pending& pending, const double* truth);
  /// A series once per name, and where its sigma is to be found.
  struct Subject {
    const Series* series = nullptr;
    int reference = -1;  // −1: withheld, or a noise estimator's
    int index = 0;       // among the reference's series
  };
  struct WithheldGroup {
    int measurement = 0;
    int group = 0;  // of the rows, counted through the parts
    const StateBlockDeclaration* norms = nullptr;
    std::vector<Series> series;
  };
  /// What a noise estimator made of R: the root of its mean diagonal over a group of rows.
  struct NoiseGroup {
    int measurement = 0;
    int group = 0;
    Series series;
  };
  /// Where live estimates are scored, after a late sample: it was seen before.
  bool is_again(Time t) {
    newest_ = std::max(newest_, t);
    return t <= seen_until_;
  }

  void size_scratch();
  void add_references();
  void add_state();
  void add_subjects();
  void add_channel_reference(const ReferencePlan& plan);
  void add_withheld(int measurement);
  void add_noise(int measurement);
  void keep_sigmas(Reference& reference);
  /// The reference's values in the sample; false where it gives none.
  bool read(const ReferencePlan& plan, const SampleView& sample, Pending& pending) const;

  void score(const Pending& pending, const double* state);
  void score_implied_state(int index);
  void score_block(const Pending& pending, const double* estimate, ConstMatrixView P);
  void score_consistency(Reference& reference, Time t, ConstMatrixView P);
  void score_withheld(const UpdateRecord& record);
  void keep_noise(const UpdateRecord& record);
  static void push_error_sigmas(Reference& reference, ConstMatrixView P);

  void warn_of_early_after(Diagnostics& warnings) const;
  nlohmann::ordered_json figures(const TimeSpan& span) const;
  nlohmann::ordered_json withheld_figures() const;
  nlohmann::ordered_json consistency_figures() const;
  nlohmann::ordered_json state_consistency(const TimeSpan& span) const;
  nlohmann::ordered_json state_figures() const;
  nlohmann::ordered_json noise_figures() const;
  nlohmann::ordered_json unscored_figures() const;
  std::vector<std::string> notes(const nlohmann::ordered_json& consistency) const;
  bool is_component(const Subject& subject) const;
  std::vector<double> with_whole_turns(const Subject& subject) const;

  const ScorePlan& plan_;
  int filter_;
  std::int64_t changes_ = 0;
  Time newest_ = no_time;      // of what was seen
  Time seen_until_ = no_time;  // it comes again up to there
  const FilterInfo& info_;
  Session* session_ = nullptr;
  Time start_ = no_time;  // of a filter that is smoothed
  StepObserver* next_ = nullptr;
  std::unique_ptr<BiasEffects> effects_;
  JumpWatch jumps_;
  GateWatch gates_;
  StartWatch first_samples_;
  std::vector<Reference> references_;
  std::vector<unsigned char> is_of_reference_;  // by channel, to the last of them
  std::vector<WatchedTrack> tracks_;
  StateNees state_nees_;
  std::vector<WithheldGroup> withheld_;
  std::vector<NoiseGroup> noise_;
  std::set<int> scored_measurements_;
  std::vector<Pending> pending_, pending_of_implied_states_;
  std::vector<ImpliedState> implied_states_;
  std::vector<Subject> subjects_;
  bool has_state_nees_ = true;
  std::vector<double> delta_, between_, truth_, outputs_, covariance_, sigma_scratch_, sigmas_;
};

/// Over all windows of all filters: mean, p50, max of each window's final and rms.
nlohmann::ordered_json across_windows(const ScorePlan& plan, const std::vector<std::unique_ptr<FilterScore>>& scores);

}  // namespace binnacle::score
