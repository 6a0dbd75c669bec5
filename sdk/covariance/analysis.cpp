// SPDX-License-Identifier: Apache-2.0
#include "covariance/analysis.hpp"

#include <algorithm>
#include <cmath>

#include "binnacle/run.hpp"
#include "binnacle/session.hpp"
#include "follower.hpp"
#include "plan.hpp"
#include "score/sections.hpp"
#include "study/summary.hpp"

namespace binnacle::covariance {

namespace {

using Json = nlohmann::ordered_json;
using GoesOn = std::function<bool()>;

constexpr double settled_within = 0.01;  // of the final value
constexpr double settled_before = 0.9;   // of the duration; what comes to rest later has not been seen to

/// Channels fed the same values at fixed rates, as a program would push them.
void feed(const Plan& plan, Follower& follower, const GoesOn& goes_on) {
  Session filter(plan.composition);
  filter.attach({plan.filter}, follower.model_log());
  if (follower.true_log()) filter.attach({plan.truth}, follower.true_log());
  std::vector<Time> next;
  for (const auto& feed : plan.feeds) next.push_back(feed.is_of_intervals ? feed.interval : 0);
  while (!follower.is_over()) {
    if (!goes_on()) throw Interrupted();
    const Time t = *std::min_element(next.begin(), next.end());
    if (t > plan.duration) break;
    for (std::size_t i = 0; i < next.size(); ++i) {
      if (next[i] != t) continue;
      const Feed& feed = plan.feeds[i];
      SampleView sample;
      sample.t = t;
      if (feed.is_of_intervals) sample.t0 = t - feed.interval;
      sample.fields = feed.values.data();
      filter.add(filter.channel(feed.channel), sample);
      next[i] += feed.interval;
    }
    filter.commit(t);
    for (const FilterId f : {FilterId{plan.filter}, FilterId{plan.truth}})
      if (!filter.healthy(f)) throw Broken(filter.diagnosis(f));
  }
}

/// The composition's sources, from beginning to end.
class Watch final : public RunObserver {
 public:
  Watch(const Plan& plan, Follower& follower, const GoesOn& goes_on)
      : plan_(plan), follower_(follower), goes_on_(goes_on) {}
  void begin(Session& session) override {
    if (follower_.true_log()) session.attach({plan_.truth}, follower_.true_log());
    session.attach({plan_.filter}, follower_.model_log());
  }
  bool progress(Time /*t*/) override {
    if (!goes_on_()) throw Interrupted();
    return !follower_.is_over();
  }

 private:
  const Plan& plan_;
  Follower& follower_;
  const GoesOn& goes_on_;
};

void run_sources(const Plan& plan, Follower& follower, std::uint64_t seed, int run, const GoesOn& goes_on) {
  Watch watch(plan, follower, goes_on);
  RunOptions options;
  options.seed = seed;
  options.run = run;
  options.observer = &watch;
  options.feeds_sinks = false;
  const RunResult result = binnacle::run(plan.composition, options);
  for (const auto& item : result.failures.items())
    if (item.code == "B080" || item.code == "B081") throw Broken(item.message);
}

double figure_of(const Request& request, const std::vector<Point>& points) {
  if (points.empty()) return std::nan("");
  if (request.statistic == Statistic::settled) {
    const double last = std::sqrt(points.back().variance);
    double from = points.front().t;
    for (std::size_t i = points.size(); i-- > 0;)
      if (std::abs(std::sqrt(points[i].variance) - last) > settled_within * last) {
        from = i + 1 < points.size() ? points[i + 1].t : points[i].t;
        break;
      }
    return from > settled_before * points.back().t ? std::nan("") : from;
  }
  const Point* point = &points.back();
  if (request.at != no_time) {
    const auto after = std::find_if(points.begin(), points.end(),
                                    [at = seconds(request.at)](const Point& p) { return p.t > at + 1e-9; });
    if (after == points.begin()) return std::nan("");
    point = &*(after - 1);
  }
  return std::sqrt(std::max(0.0, request.statistic == Statistic::sigma ? point->variance : point->own_variance));
}

LoadOptions options_of(const LoadOptions& options, const study::Variant& variant) {
  LoadOptions load = options;
  load.patches = variant.patches;
  return load;
}

/// What a variant's errors come of, summed over its runs.
class Budget {
 public:
  void add(const Subject& subject) {
    if (subject.points.empty()) return;
    if (!parts_.contains(subject.name)) parts_[subject.name] = Json::object();
    auto& parts = parts_[subject.name];
    for (std::size_t s = 0; s < subject.names.size(); ++s)
      parts[subject.names[s]] = parts.value(subject.names[s], 0.0) + subject.parts[static_cast<Eigen::Index>(s)];
  }
  /// { FILTER/NAME: { SOURCE: share } }
  Json shares(const std::string& filter) const {
    Json all = Json::object();
    for (const auto& [name, parts] : parts_.items()) {
      double sum = 0;
      for (const auto& [source, part] : parts.items()) sum += part.get<double>();
      Json& shares = all[filter + "/" + name] = Json::object();
      for (const auto& [source, part] : parts.items()) shares[source] = part.get<double>() / sum;
    }
    return all;
  }

 private:
  Json parts_ = Json::object();
};

/// One variant, as often as it is to be run.
class VariantAnalysis {
 public:
  VariantAnalysis(const study::Study& study, const study::Variant& variant, Plan plan)
      : study_(study), variant_(variant), plan_(std::move(plan)) {
    for (const auto& metric : variant.metrics) {
      const auto request = request_of(metric.name);
      if (name_of(metric) != filter()) continue;
      if (std::find(names_.begin(), names_.end(), request.name) == names_.end()) names_.push_back(request.name);
      if (request.at != no_time) times_.push_back(request.at);
    }
  }

  study::Figures carry_out(int run, const GoesOn& goes_on) {
    study::Figures figures;
    figures.values.assign(study_.metrics().size(), score::MetricValue{std::nan(""), 0, 0});
    try {
      Follower follower(plan_, names_, times_);
      if (plan_.feeds.empty())
        run_sources(plan_, follower, study_.seed(), run, goes_on);
      else
        feed(plan_, follower, goes_on);
      follower.finish();
      for (std::size_t m = 0; m < study_.metrics().size(); ++m) {
        if (variant_.position[m] < 0) continue;
        const auto request = request_of(study_.metrics()[m].name);
        for (const auto& subject : follower.subjects())
          if (subject.name == request.name) figures.values[m].value = figure_of(request, subject.points);
      }
      for (const auto& subject : follower.subjects()) budget_.add(subject);
      figures.state = study::Figures::State::finished;
    } catch (const Broken& broken) {
      figures.state = study::Figures::State::failed;
      figures.failure = broken.what();
    }
    return figures;
  }

  Json budget() const { return budget_.shares(filter()); }

 private:
  const std::string& filter() const {
    return plan_.composition->filters()[static_cast<std::size_t>(plan_.filter)].name;
  }
  const std::string& name_of(const score::Metric& metric) const {
    return variant_.composition->filters()[static_cast<std::size_t>(metric.filter)].name;
  }

  const study::Study& study_;
  const study::Variant& variant_;
  Plan plan_;
  std::vector<std::string> names_;
  std::vector<Time> times_;
  Budget budget_;
};

}  // namespace

bool is_in(const Config& config) { return config.contains("/covariance"); }

study::Study load(const std::filesystem::path& path, const LoadOptions& options) {
  study::StudyOptions study_options;
  study_options.load = options;
  study_options.section = "/covariance";
  study_options.read_metric = read_metric;
  study_options.runs = runs_of(score::load_config(path, options));
  auto study = study::Study::load(path, study_options);
  Diagnostics diagnostics;
  for (const auto& variant : study.variants()) {
    Diagnostics own;
    read_plan(score::load_config(path, options_of(options, variant)), path, options, variant.composition, own);
    if (own.has_errors()) {
      diagnostics.merge(own);
      break;  // the others would mostly say the same
    }
  }
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
  return study;
}

Json analyse(const study::Study& study, const std::filesystem::path& path, const LoadOptions& options,
             const GoesOn& goes_on) {
  const auto runs = static_cast<std::size_t>(study.runs());
  study::Results results(study.variants().size(), runs);
  std::vector<Json> budgets;
  for (std::size_t v = 0; v < study.variants().size(); ++v) {
    const auto& variant = study.variants()[v];
    Diagnostics diagnostics;
    Plan plan = read_plan(score::load_config(path, options_of(options, variant)), path, options, variant.composition,
                          diagnostics);
    if (diagnostics.has_errors()) throw ConfigError(diagnostics);
    VariantAnalysis analysis(study, variant, std::move(plan));
    for (std::size_t run = 0; run < runs; ++run)
      results.at(v, run) = analysis.carry_out(static_cast<int>(run), goes_on);
    budgets.push_back(analysis.budget());
  }
  Json summary = study::summarize(study, results);
  for (std::size_t v = 0; v < study.variants().size(); ++v)
    summary["variants"][study.variants()[v].name]["budget"] = std::move(budgets[v]);
  return summary;
}

}  // namespace binnacle::covariance
