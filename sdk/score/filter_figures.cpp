// SPDX-License-Identifier: Apache-2.0
// What the errors of a run come to: summaries and metrics.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <numbers>

#include "binnacle/unit.hpp"
#include "filter_score.hpp"
#include "overconfident.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

using Json = nlohmann::ordered_json;

Json FilterScore::summary() const {
  Json summary;
  summary["reference"] = figures(plan_.span);
  Json windows = Json::object();
  for (const auto& window : plan_.windows)
    if (window.filter < 0 || window.filter == filter_) windows[window.name] = figures(window.span);
  if (!windows.empty()) summary["windows"] = windows;
  if (auto withheld = withheld_figures(); !withheld.empty()) summary["withheld"] = std::move(withheld);
  const Json consistency = consistency_figures();
  if (!consistency.empty()) summary["consistency"] = consistency;
  if (auto noise = noise_figures(); !noise.empty()) summary["noise"] = std::move(noise);
  if (auto unscored = unscored_figures(); !unscored.empty()) summary["unscored"] = std::move(unscored);
  if (const auto all = notes(consistency); !all.empty()) summary["notes"] = all;
  return summary;
}

/// A time that is meant from the start, where labels are seconds of the week or since 1970.
void FilterScore::warn_of_early_after(Diagnostics& warnings) const {
  const TimeSpan& span = plan_.span;
  if (!session_->started(FilterId{filter_})) return;
  const Time length = session_->time(FilterId{filter_}) - start();
  if (span.from_is_relative || span.from == all_time.from || start() - span.from <= length) return;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "'after' is %.1f s, long before '%s' starts at %.1f s, so nothing is left out; likely intent: \"start+%g s\"",
      seconds(span.from), info_.name.c_str(), seconds(start()), seconds(span.from));
  warnings.warning("B129", plan_.place.origin, plan_.place.pointer + "/after", text);
}

Json FilterScore::figures(const TimeSpan& span) const {
  Json figures = Json::object();
  for (const Series* series : reference_series()) {
    auto value = statistics(*series, span, start());
    if (!value.is_null()) figures[series->name] = std::move(value);
  }
  return figures;
}

void FilterScore::warn_of_spans(Diagnostics& warnings) const {
  bool is_scored = false;
  for (const Series* series : reference_series()) is_scored = is_scored || !series->t.empty();
  if (!is_scored) return;
  const auto look = [&](const TimeSpan& span, const Place& place, const std::string& name) {
    if (place.pointer.empty() || !figures(span).empty()) return;
    char ran[80];
    std::snprintf(ran, sizeof ran, "%.1f s to %.1f s", seconds(start()), seconds(session_->time(FilterId{filter_})));
    warnings.warning("B121", place.origin, place.pointer,
                     "no sample of a reference of '" + info_.name + "' lies in " + name +
                         ", so nothing is evaluated; the filter ran from " + ran);
  };
  look(plan_.span, plan_.place, "'after' to 'until'");
  for (const auto& window : plan_.windows)
    if (window.filter < 0 || window.filter == filter_) look(window.span, window.place, "'" + window.name + "'");
  warn_of_early_after(warnings);
}

Json FilterScore::withheld_figures() const {
  Json withheld = Json::object();
  for (const auto& group : withheld_)
    for (const auto& series : group.series) {
      auto value = statistics(series, plan_.span, start());
      if (!value.is_null())
        withheld[info_.measurements[as_size(group.measurement)].name][series.name] = std::move(value);
    }
  return withheld;
}

Json FilterScore::consistency_figures() const {
  Json consistency = Json::object();
  for (const auto& reference : references_) {
    double sum = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < reference.nees.t.size(); ++i)
      if (plan_.span.contains(reference.nees.t[i], start())) {
        sum += reference.nees.values[i];
        ++n;
      }
    if (n > 0)
      consistency[reference.name] = {{"nees_mean", sum / static_cast<double>(n)},
                                     {"dof", reference.block->active.size()},
                                     {"n", n}};
  }
  if (auto state = state_figures(); !state.is_null()) consistency[state_name] = std::move(state);
  return consistency;
}

/// Null where no epoch of the span gives the whole state.
Json FilterScore::state_consistency(const TimeSpan& span) const {
  const Series &nees = state_nees_.nees(), &dof = state_nees_.dof();
  double sum = 0, dof_sum = 0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < nees.t.size(); ++i) {
    if (!span.contains(nees.t[i], start())) continue;
    sum += nees.values[i];
    dof_sum += dof.values[i];
    ++n;
  }
  if (n == 0) return nullptr;
  // Where P has the same rank all the time, as nearly always, it is an integer, like that of a block.
  const double mean_dof = dof_sum / static_cast<double>(n);
  Json figures{{"nees_mean", sum / static_cast<double>(n)}};
  figures["dof"] = mean_dof == std::round(mean_dof) ? Json(static_cast<int>(mean_dof)) : Json(mean_dof);
  figures["n"] = n;
  return figures;
}

/// Of a single block there is nothing to say that its own NEES does not.
Json FilterScore::state_figures() const {
  const std::vector<std::string> blocks = state_nees_.blocks();
  Json figures = blocks.size() < 2 ? Json() : state_consistency(plan_.span);
  if (figures.is_null()) return figures;
  figures["blocks"] = blocks;
  figures["without"] = Json::array();
  for (const auto& block : info_.blocks)
    if (!block.active.empty() && index_of(blocks, block.name) < 0) figures["without"].push_back(block.name);
  for (const auto& window : plan_.windows)
    if (window.filter < 0 || window.filter == filter_)
      if (auto inside = state_consistency(window.span); !inside.is_null())
        figures["windows"][window.name] = std::move(inside);
  return figures;
}

Json FilterScore::noise_figures() const {
  Json noise = Json::object();
  for (const auto& group : noise_) {
    auto value = statistics(group.series, plan_.span, start());
    if (!value.is_null()) noise[group.series.name] = std::move(value);
  }
  return noise;
}

/// The 1-sigma at the end of what has no reference, where withheld samples are one: they show the errors of few blocks.
Json FilterScore::unscored_figures() const {
  Json unscored = Json::object();
  if (!session_ || scored_measurements_.empty() || !session_->started({filter_}) || !session_->healthy({filter_}))
    return unscored;
  const auto is_scored = [&](const BlockInfo& block) {
    const auto all = reference_series();
    return std::any_of(all.begin(), all.end(), [&](const Series* series) {
      return !series->t.empty() && series->name.starts_with(block.name + ".");
    });
  };
  for (std::size_t b = 0; b < info_.blocks.size(); ++b) {
    const auto& block = info_.blocks[b];
    if (block.active.empty() || is_scored(block)) continue;
    const auto& outputs = block.declaration->outputs;
    std::vector<double> sigmas(outputs.size());
    session_->read_sigma({{filter_}, static_cast<int>(b)}, sigmas);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const auto& shown = outputs[i].display_unit.empty() ? outputs[i].unit : outputs[i].display_unit;
      const auto unit = parse_unit(shown);
      unscored[block.name + "." + outputs[i].name] = {{"sigma", sigmas[i] / (unit ? unit->scale : 1.0)},
                                                      {"unit", shown}};
    }
  }
  return unscored;
}

std::vector<std::string> FilterScore::notes(const Json& consistency) const {
  std::vector<std::string> all;
  if (session_) {
    std::vector<MeasurementCounts> counts;
    for (int m = 0; m < static_cast<int>(info_.measurements.size()); ++m)
      counts.push_back(session_->counts(MeasurementId{{filter_}, m}));
    all = gates_.notes(counts);
    if (session_->started({filter_})) std::ranges::move(first_samples_.notes(start()), std::back_inserter(all));
  }
  if (auto note = overconfident(consistency); !note.empty()) all.push_back(std::move(note));
  return all;
}

std::vector<const Series*> FilterScore::reference_series() const {
  std::vector<const Series*> all;
  std::set<std::string> names;
  const auto add = [&](const std::vector<Series>& list) {
    for (const auto& series : list)
      if (names.insert(series.name).second) all.push_back(&series);
  };
  for (const auto& reference : references_) add(reference.series);
  for (const auto& group : withheld_)
    if (scored_measurements_.contains(group.measurement)) add(group.series);
  return all;
}

std::vector<Scored> FilterScore::scored() const {
  std::vector<Scored> all;
  for (std::size_t i = 0; i < subjects_.size(); ++i) {
    const auto& subject = subjects_[i];
    Scored entry;
    entry.name = subject.series->name;
    entry.unit = subject.series->unit;
    entry.display_unit = subject.series->display_unit.empty() ? entry.unit : subject.series->display_unit;
    entry.index = static_cast<int>(i);
    entry.has_sigma = subject.reference >= 0;
    entry.has_nees = entry.has_sigma && is_component(subject);
    all.push_back(std::move(entry));
  }
  for (std::size_t r = 0; r < references_.size(); ++r)
    if (references_[r].is_whole)
      all.push_back({references_[r].name, "1", "1", static_cast<int>(r), NeesOf::block, false, true});
  if (state_nees_.is_there()) all.push_back({state_name, "1", "1", 0, NeesOf::state, false, true});
  return all;
}

void FilterScore::show_errors(RunObserver& observer) const {
  for (const auto& subject : subjects_) {
    const auto& series = *subject.series;
    std::span<const double> sigma;
    if (subject.reference >= 0 && !references_[as_size(subject.reference)].sigmas.empty())
      sigma = references_[as_size(subject.reference)].sigmas[as_size(subject.index)];
    observer.scored(filter_, {series.name, series.unit, series.display_unit, series.t, series.values, sigma});
  }
  for (const auto& reference : references_)
    if (reference.is_whole)
      observer.scored(filter_, {reference.name + ".nees", "1", "1", reference.nees.t, reference.nees.values, {}});
  if (const Series& nees = state_nees_.nees(); state_nees_.blocks().size() > 1 && !nees.t.empty())
    observer.scored(filter_, {nees.name, nees.unit, nees.display_unit, nees.t, nees.values, {}});
}

MetricValue FilterScore::value(const Metric& metric) const {
  if (metric.quantity == MetricQuantity::nis) {
    if (!session_) return {not_a_number, 0, 0};
    const MeasurementCounts counts = session_->counts({{filter_}, metric.subject});
    if (counts.nis_count == 0) return {not_a_number, 0, 0};
    return {counts.nis_mean, counts.dof_mean, static_cast<double>(counts.nis_count)};
  }
  if (metric.quantity == MetricQuantity::segments) {
    const SegmentErrors errors = track_of(metric).errors(plan_.segments, plan_.span, start());
    if (errors.count == 0) return {not_a_number, 0, 0};
    return {metric.statistic == MetricStatistic::translation ? errors.translation : errors.rotation, 0, 0};
  }
  const auto figure = [&](const Series& series, const std::vector<double>& values) {
    return over_time(series.t, values, metric, plan_.span, start());
  };
  if (metric.nees_of == NeesOf::state) {
    const Series &nees = state_nees_.nees(), &dof = state_nees_.dof();
    return {figure(nees, nees.values), figure(dof, dof.values), 1};
  }
  if (metric.nees_of == NeesOf::block) {
    const auto& reference = references_[as_size(metric.subject)];
    return {figure(reference.nees, reference.nees.values), static_cast<double>(reference.block->active.size()), 1};
  }
  const auto& subject = subjects_[as_size(metric.subject)];
  const Series& series = *subject.series;
  if (metric.statistic == MetricStatistic::drift && subject.reference >= 0 && is_component(subject) &&
      references_[as_size(subject.reference)].block->declaration->kind == "attitude")
    return {figure(series, with_whole_turns(subject)), 0, 0};
  if (metric.quantity == MetricQuantity::error) return {figure(series, series.values), 0, 0};
  auto values = references_[as_size(subject.reference)].sigmas[as_size(subject.index)];
  if (metric.quantity == MetricQuantity::sigma) return {figure(series, values), 0, 0};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double ratio = series.values[i] / values[i];
    values[i] = ratio * ratio;
  }
  return {figure(series, values), 1, 1};
}

bool FilterScore::is_component(const Subject& subject) const {
  const auto& reference = references_[as_size(subject.reference)];
  return reference.is_whole && subject.index < reference.block->declaration->dof();
}

/// The component of an attitude's error with whole turns about its axis added, so that it never jumps by one.
std::vector<double> FilterScore::with_whole_turns(const Subject& subject) const {
  constexpr double turn = 2 * std::numbers::pi;
  const auto& series = references_[as_size(subject.reference)].series;
  std::vector<double> values = subject.series->values;
  std::array<double, 3> last{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::array<double, 3> now = {series[0].values[i], series[1].values[i], series[2].values[i]};
    const double angle = std::hypot(now[0], now[1], now[2]);
    if (i > 0 && angle > 0) {
      // Of all vectors that are this rotation, now·(1 + 2πk/angle), the one nearest to the last.
      const double along = (last[0] * now[0] + last[1] * now[1] + last[2] * now[2]) / angle;
      const double stretch = (angle + turn * std::round((along - angle) / turn)) / angle;
      for (double& component : now) component *= stretch;
    }
    last = now;
    values[i] = now[as_size(subject.index)];
  }
  return values;
}

namespace {

/// One figure of every window, by error and statistic.
struct WindowFigures {
  std::string name, unit;
  std::map<std::string, std::vector<double>> by_statistic;
};

WindowFigures& named(std::vector<WindowFigures>& all, const std::string& name) {
  const auto found = std::find_if(all.begin(), all.end(), [&](const auto& entry) { return entry.name == name; });
  return found != all.end() ? *found : all.emplace_back(WindowFigures{name, {}, {}});
}

std::vector<WindowFigures> collected(const ScorePlan& plan, const std::vector<std::unique_ptr<FilterScore>>& scores) {
  std::vector<WindowFigures> all;
  for (std::size_t f = 0; f < scores.size(); ++f)
    for (const auto& window : plan.windows) {
      if (window.filter >= 0 && window.filter != static_cast<int>(f)) continue;
      for (const Series* series : scores[f]->reference_series()) {
        const auto value = statistics(*series, window.span, scores[f]->start());
        if (value.is_null()) continue;
        WindowFigures& entry = named(all, series->name);
        entry.unit = value["unit"];
        for (const char* key : {"rms", "max", "final"})
          entry.by_statistic[key].push_back(std::abs(value[key].get<double>()));
      }
    }
  return all;
}

}  // namespace

Json across_windows(const ScorePlan& plan, const std::vector<std::unique_ptr<FilterScore>>& scores) {
  Json across = Json::object();
  for (auto& figures : collected(plan, scores)) {
    Json entry = Json::object();
    for (auto& [key, values] : figures.by_statistic) {
      std::sort(values.begin(), values.end());
      double sum = 0;
      for (const double value : values) sum += value;
      entry[key] = {{"mean", sum / static_cast<double>(values.size())},
                    {"p50", quantile(values, 0.5)},
                    {"max", values.back()}};
      entry["n"] = values.size();
    }
    entry["unit"] = figures.unit;
    across[figures.name] = std::move(entry);
  }
  return across;
}

}  // namespace binnacle::score
