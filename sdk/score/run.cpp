// SPDX-License-Identifier: Apache-2.0
#include "score/run.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "binnacle/run.hpp"
#include "binnacle/unit.hpp"
#include "cause_watch.hpp"
#include "filter_score.hpp"
#include "plan.hpp"
#include "recorder.hpp"
#include "run_figures.hpp"
#include "smoothing.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

using Json = nlohmann::ordered_json;

Json live_figures(const LiveFigures& live) {
  Json json{{"channels", Json::object()}, {"sources", Json::object()}, {"seconds", live.seconds}};
  for (const auto& channel : live.channels)
    json["channels"][channel.name] = {{"samples", channel.samples},
                                      {"behind", channel.behind},
                                      {"latency_p50_s", channel.p50},
                                      {"latency_p99_s", channel.p99},
                                      {"latency_max_s", channel.longest}};
  for (const auto& source : live.sources)
    json["sources"][source.name] = {{"longest_queue", source.longest_queue},
                                    {"lost", source.lost},
                                    {"unusable", source.unusable}};
  return json;
}

bool runs_again(const SmoothingPlan& smoothing) { return !smoothing.lag; }

/// Looks on while a composition runs, and leaves the figures when it is over.
class Scorer final : public binnacle::RunObserver {
 public:
  Scorer(const Composition& composition, const RunOptions& options)
      : plan_(plan_of(composition)), observer_(options.observer ? *options.observer : nobody_), options_(options) {
    for (std::size_t f = 0; f < plan_->filters.size() - plan_->smoothings.size(); ++f)
      scores_.push_back(std::make_unique<FilterScore>(*plan_, static_cast<int>(f)));
    if (options.wants_summary)
      for (const auto& motion : plan_->motion) causes_.push_back(std::make_unique<CauseWatch>(motion));
    records_ = options.observer && options.observer->wants_records();
    if (records_)
      for (auto& score : scores_) score->keep_sigmas();
  }

  void begin(Session& session) override {
    session_ = &session;
    observer_.begin_run(session);
    for (std::size_t f = 0; f < scores_.size(); ++f)
      scores_[f]->attach(session, observer_.step_observer(static_cast<int>(f)));
    if (records_) recorder_ = std::make_unique<Recorder>(session, scores_, observer_, *plan_);
    if (std::ranges::any_of(plan_->smoothings, runs_again) && !can_rerun(session)) refuse_smoothing();
    if (!plan_->smoothings.empty()) smoothing_ = std::make_unique<Smoothing>(*plan_, session, observer_, records_);
    if (recorder_ && smoothing_) recorder_->keep_times();
    if (!options_.wants_summary)
      for (auto& score : scores_) score->watch_only();
    for (const auto* list : {&plan_->metrics, &options_.metrics})
      for (const auto& metric : *list) score_of(metric.filter).watch(metric);
  }
  void sampled(int channel, const SampleView& sample) override {
    if (smoothing_ && smoothing_->is_running_again()) return;
    show(channel, sample, false);
  }
  void settled(int channel, const SampleView& sample) override {
    if (smoothing_ && smoothing_->is_running_again()) return;
    show(channel, sample, true);
  }
  void after_instant() override {
    if (recorder_) recorder_->after_instant();
    if (smoothing_) smoothing_->after_instant();
    observer_.after_instant();
  }
  void exchange(StateBytes& bytes) override {
    bool are_records_there = records_;
    bytes.value(are_records_there);
    bytes.value(data_begin_);
    if (are_records_there != records_)
      throw ConfigError(Diagnostic{Severity::error,
                                   "B084",
                                   {},
                                   "",
                                   std::string("the run cannot be resumed: it began with") +
                                       (are_records_there ? "" : "out") + " --out"});
    for (auto& score : scores_) score->exchange(bytes);
    for (auto& cause : causes_) cause->exchange(bytes);
    if (recorder_) recorder_->exchange(bytes);
    if (smoothing_) smoothing_->exchange(bytes);
    observer_.exchange(bytes);
  }
  void noted(const Diagnostic& note) override { observer_.noted(note); }
  bool wants_arrivals() const override { return observer_.wants_arrivals(); }
  void arrived(const Arrival& arrival) override { observer_.arrived(arrival); }
  bool progress(Time t) override {
    if (data_begin_ == no_time) data_begin_ = t;  // the first call is at the first instant
    return observer_.progress(t);
  }

  void finished() override {
    observer_.finished();
    if (recorder_) recorder_->finish();
    for (auto& score : scores_) score->finish();
    if (records_)
      for (const auto& score : scores_) score->show_errors(observer_);
    std::vector<std::vector<Time>> none(scores_.size());
    if (smoothing_) smoothing_->finish(recorder_ ? recorder_->times() : none);
    for (int f = 0; f < static_cast<int>(scores_.size()); ++f) {
      verdicts_.push_back(sized_verdict(*session_, {f}, scores_[as_size(f)]->effects(), &scores_[as_size(f)]->jumps(),
                                        plan_->limits[as_size(f)]));
      verdict_ = std::max(verdict_, verdict_of(verdicts_.back()));
    }
    for (const auto& metric : options_.metrics) values_.push_back(value(metric));
    if (options_.wants_summary) summarize();
  }

  std::vector<MetricValue> values() const { return values_; }
  Verdict verdict() const { return verdict_; }
  const Diagnostics& doubts() const { return doubts_; }

  Json summary(const Diagnostics& warnings, const std::optional<LiveFigures>& live) const {
    Json summary{{"filters", filters_}};
    if (live) summary["live"] = live_figures(*live);
    if (!metrics_.empty()) summary["metrics"] = metrics_;
    if (!windows_.empty()) summary["windows"] = windows_;
    summary["warnings"] = Json::array();
    for (const auto* list : {&doubts_, &warnings})
      for (const auto& warning : list->items()) summary["warnings"].push_back(to_string(warning));
    summary["seed"] = options_.seed;
    return summary;
  }

 private:
  void summarize() {
    for (std::size_t f = 0; f < scores_.size(); ++f) {
      auto& figures = filters_[plan_->filters[f].name] = scores_[f]->summary();
      const FilterId filter{static_cast<int>(f)};
      figures.update(run_figures(*session_, filter, verdicts_[f]));
      add_wait(filter, figures);
      doubts_.merge(score::doubts(*session_, filter, verdicts_[f]));
      scores_[f]->warn_of_spans(doubts_);
    }
    add_causes();
    for (std::size_t i = 0; i < plan_->smoothings.size(); ++i)
      filters_[plan_->filters[as_size(plan_->smoothings[i].as)].name] = smoothing_->summary(i);
    for (const auto& metric : plan_->metrics) {
      const auto unit = parse_unit(metric.unit);
      metrics_[metric.name] = {{"value", value(metric).value / (unit ? unit->scale : 1.0)}, {"unit", metric.unit}};
    }
    for (const auto* list : {&plan_->metrics, &options_.metrics})
      for (const auto& metric : *list)
        if (metric.quantity == MetricQuantity::segments) score_of(metric.filter).warn_of_no_segments(metric, doubts_);
    windows_ = across_windows(*plan_, scores_);
  }
  /// How long there was no estimate, and of which channels a sample had to come before there was one.
  void add_wait(FilterId filter, Json& figures) const {
    constexpr double least = 1;  // s
    if (!session_->started(filter) || data_begin_ == no_time) return;
    const double wait = seconds(session_->start_time(filter) - data_begin_);
    if (wait < least) return;
    Json& waited = figures["waited"] = {{"seconds", wait}, {"for", Json::array()}};
    const Composition& composition = session_->composition();
    for (const auto& initial : composition.filters()[as_size(filter.index)].starts_when)
      waited["for"].push_back(composition.channels()[as_size(initial.channel)].name);
  }
  [[noreturn]] static void refuse_smoothing() {
    throw ConfigError(Diagnostic{Severity::error,
                                 "B143",
                                 {},
                                 "/filters",
                                 "what comes once, of live sources or recorded input, cannot be smoothed when the run "
                                 "is over; a \"fixed_lag\" smooths it during the run"});
  }
  /// Filters with history see references as they are settled, unless their live estimates are scored.
  bool is_scored_settled(int filter) const {
    return plan_->estimates == Estimates::settled && plan_->filters[as_size(filter)].history > 0;
  }
  void show(int channel, const SampleView& sample, bool is_settled) {
    if (smoothing_)
      smoothing_->sampled(channel, sample, [&](int filter) { return is_scored_settled(filter) == is_settled; });
    for (std::size_t f = 0; f < scores_.size(); ++f)
      if (is_scored_settled(static_cast<int>(f)) == is_settled) scores_[f]->reference(channel, sample);
    for (std::size_t i = 0; i < causes_.size(); ++i)
      if (is_scored_settled(plan_->motion[i].filter) == is_settled) causes_[i]->sampled(channel, sample);
  }
  /// Only where there is something to explain.
  void add_causes() {
    for (std::size_t i = 0; i < causes_.size(); ++i) {
      const FilterId filter{plan_->motion[i].filter};
      if (verdict_of(verdicts_[as_size(filter.index)]) == Verdict::ok) continue;
      const Diagnostics causes = causes_[i]->causes();
      doubts_.merge(causes);
      Json& list = filters_[plan_->filters[as_size(filter.index)].name]["verdict"]["likely_causes"] = Json::array();
      for (const auto& cause : causes.items()) list.push_back({{"code", cause.code}, {"text", cause.message}});
    }
  }
  FilterScore& score_of(int filter) const {
    if (as_size(filter) < scores_.size()) return *scores_[as_size(filter)];
    return smoothing_->score(as_size(filter) - scores_.size());
  }
  MetricValue value(const Metric& metric) const { return score_of(metric.filter).value(metric); }

  std::shared_ptr<const ScorePlan> plan_;
  score::RunObserver nobody_;
  score::RunObserver& observer_;
  const RunOptions& options_;
  Scores scores_;
  std::vector<std::unique_ptr<CauseWatch>> causes_;  // of plan_->motion
  std::unique_ptr<Recorder> recorder_;
  std::unique_ptr<Smoothing> smoothing_;
  bool records_ = false;
  Json filters_ = Json::object(), metrics_ = Json::object(), windows_ = Json::object();
  std::vector<MetricValue> values_;
  std::vector<Json> verdicts_;  // by filter
  Verdict verdict_ = Verdict::ok;
  Diagnostics doubts_;
  const Session* session_ = nullptr;  // of the run under way
  Time data_begin_ = no_time;
};

}  // namespace

namespace {

/// One run and who scores it.
class ScoredRun {
 public:
  ScoredRun(const std::shared_ptr<const Composition>& composition, const RunOptions& options)
      : scorer_(*composition, options), request_{composition}, wants_summary_(options.wants_summary) {
    auto& to = request_.options;
    to.estimates = plan_of(*composition)->estimates;
    to.seed = options.seed;
    to.run = options.run;
    to.observer = &scorer_;
    to.feeds_sinks = options.feeds_sinks;
    to.pace = options.pace;
    to.input = options.input;
    to.checkpoints = options.checkpoints;
  }
  ScoredRun(const ScoredRun&) = delete;
  ScoredRun& operator=(const ScoredRun&) = delete;

  const binnacle::RunRequest& request() const { return request_; }
  RunResult result(binnacle::RunResult&& result) const {
    Json summary;
    if (wants_summary_) {
      summary = scorer_.summary(result.warnings, result.live);
      summary["wall_s"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    }
    return {std::move(summary),         scorer_.values(),  std::move(result.warnings),
            std::move(result.failures), scorer_.verdict(), scorer_.doubts()};
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  Scorer scorer_;
  binnacle::RunRequest request_;
  bool wants_summary_;
};

}  // namespace

RunResult run(const std::shared_ptr<const Composition>& composition, const RunOptions& options) {
  const ScoredRun scored(composition, options);
  return scored.result(binnacle::run(composition, scored.request().options));
}

bool can_run_together(const Composition& composition) {
  return have_same_sources(composition, composition) &&
         std::ranges::none_of(plan_of(composition)->smoothings, runs_again);
}

std::vector<RunOutcome> run_together(const std::vector<RunRequest>& requests) {
  std::vector<std::unique_ptr<ScoredRun>> scored;
  std::vector<binnacle::RunRequest> together;
  for (const auto& [composition, options] : requests) {
    scored.push_back(std::make_unique<ScoredRun>(composition, options));
    together.push_back(scored.back()->request());
  }
  auto ended = binnacle::run_together(together);
  std::vector<RunOutcome> outcomes(requests.size());
  for (std::size_t i = 0; i < ended.size(); ++i) {
    outcomes[i].thrown = ended[i].thrown;
    if (!ended[i].thrown) outcomes[i].result = scored[i]->result(std::move(ended[i].result));
  }
  return outcomes;
}

}  // namespace binnacle::score
