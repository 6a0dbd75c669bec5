// SPDX-License-Identifier: Apache-2.0
#include "score/metric.hpp"

#include <utility>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "filter_score.hpp"
#include "plan.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

using Names = std::vector<std::string>;

/// "; did you mean 'rms'? (statistics: mean, rms)"
std::string help(std::string_view text, const Names& names, const std::string& what) {
  const std::string near = closest(text, names);
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "" : ", ") + name;
  return (near.empty() ? "" : "; did you mean " + in_quotes(near) + "?") + " (" + what + ": " +
         (list.empty() ? "none" : list) + ")";
}

constexpr std::pair<const char*, MetricStatistic> statistics_of_errors[] = {
    {"mean", MetricStatistic::mean},   {"rms", MetricStatistic::rms}, {"max", MetricStatistic::max},
    {"final", MetricStatistic::final}, {"p50", MetricStatistic::p50}, {"p95", MetricStatistic::p95},
    {"drift", MetricStatistic::drift}};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

/// The last part: "rms", "at 100 s", "sigma", "nees at start+5 s", "nis". Empty, or what is wrong.
std::string read_statistic(std::string_view text, Metric& metric) {
  std::string_view rest = text;
  const auto take = [&rest](std::string_view word) {
    if (!rest.starts_with(word) || (rest.size() > word.size() && rest[word.size()] != ' ')) return false;
    rest = trimmed(rest.substr(word.size()));
    return true;
  };
  if (take("sigma")) {
    metric.quantity = MetricQuantity::sigma;
    metric.statistic = MetricStatistic::final;
    if (rest.empty()) return {};
  } else if (take("nees")) {
    metric.quantity = MetricQuantity::nees;
    metric.statistic = MetricStatistic::mean;
    if (rest.empty()) return {};
  } else if (rest == "translation" || rest == "rotation") {
    metric.quantity = MetricQuantity::segments;
    metric.statistic = rest == "translation" ? MetricStatistic::translation : MetricStatistic::rotation;
    return {};
  } else if (rest == "nis") {
    metric.quantity = MetricQuantity::nis;
    metric.statistic = MetricStatistic::mean;
    return {};
  }
  if (take("at")) {
    metric.statistic = MetricStatistic::at;
    metric.at_is_from_start = rest.starts_with("start+");
    if (metric.at_is_from_start) rest.remove_prefix(6);
    const auto time = parse_time(trimmed(rest));
    if (!time) return in_quotes(text) + " names no time: " + time.error();
    metric.at = *time;
    return {};
  }
  if (rest == text)
    for (const auto& [name, statistic] : statistics_of_errors)
      if (text == name) {
        metric.statistic = statistic;
        return {};
      }
  return "there is no statistic " + in_quotes(text) +
         help(text,
              {"mean", "rms", "max", "final", "drift", "p50", "p95", "sigma", "nees", "nis", "at 100 s", "translation",
               "rotation"},
              "statistics");
}

std::string find_measurement(const ScorePlan& plan, std::string_view subject, Metric& metric) {
  const FilterInfo& filter = plan.filters[as_size(metric.filter)];
  for (const SmoothingPlan& smoothing : plan.smoothings)
    if (smoothing.as == metric.filter)
      return in_quotes(filter.name) + " is smoothed and has no innovations; NIS is of " +
             in_quotes(plan.filters[as_size(smoothing.of)].name);
  const Names names = names_of(filter.measurements);
  metric.subject = index_of(names, subject);
  if (metric.subject < 0)
    return "filter " + in_quotes(filter.name) + " has no measurement " + in_quotes(subject) +
           help(subject, names, "measurements");
  metric.unit = metric.si_unit = "1";
  return {};
}

/// BLOCK.segments, of a position in metres, where an attitude of the filter is scored too.
std::string find_track(const ScorePlan& plan, std::string_view subject, Metric& metric) {
  const FilterScore score(plan, metric.filter);
  const std::vector<FilterScore::Track> tracks = score.tracks();
  Names names;
  for (const auto& track : tracks) names.push_back(track.name);
  const int index = index_of(names, subject);
  if (index < 0)
    return "filter " + in_quotes(plan.filters[as_size(metric.filter)].name) + " has no segments " + in_quotes(subject) +
           ": they are of a position in metres and an attitude whose references give all outputs of both" +
           help(subject, names, "there are");
  if (tracks[as_size(index)].attitudes.size() > 1 && plan.segments.attitude.empty())
    return "several attitudes of filter " + in_quotes(plan.filters[as_size(metric.filter)].name) + " are scored (" +
           listed(tracks[as_size(index)].attitudes) + "); name one as 'attitude' of 'segments' in 'evaluate'";
  metric.subject = index;
  const bool is_translation = metric.statistic == MetricStatistic::translation;
  metric.si_unit = is_translation ? "1" : "rad/m";
  metric.unit = is_translation ? "%" : "deg/m";
  return {};
}

std::string find_scored(const ScorePlan& plan, std::string_view subject, Metric& metric) {
  const FilterScore score(plan, metric.filter);
  Names names;
  for (const auto& scored : score.scored()) {
    const bool has_sigma = metric.quantity == MetricQuantity::error || scored.has_sigma;
    const bool can_be =
        metric.quantity == MetricQuantity::nees ? scored.has_nees : has_sigma && scored.nees_of == NeesOf::component;
    if (!can_be) continue;
    names.push_back(scored.name);
    if (scored.name != subject) continue;
    metric.subject = scored.index;
    metric.nees_of = scored.nees_of;
    const bool is_plain = metric.quantity == MetricQuantity::nees;
    metric.si_unit = is_plain ? "1" : scored.unit;
    metric.unit = is_plain ? "1" : scored.display_unit;
    return {};
  }
  const char* const by = metric.quantity == MetricQuantity::error ? " is scored by a reference"
                         : metric.quantity == MetricQuantity::sigma
                             ? " has a sigma and is scored by a reference"
                             : " has a NEES: its reference must give all outputs";
  const auto& filter = plan.filters[as_size(metric.filter)];
  return "no " + in_quotes(subject) + " of filter " + in_quotes(filter.name) + by + help(subject, names, "there are");
}

}  // namespace

Parsed<Metric> read_metric(const ScorePlan& plan, std::string_view text) {
  const auto failure = [&](const std::string& message) {
    return Parsed<Metric>::failure("metric " + in_quotes(text) + ": " + message);
  };
  const auto first = text.find('/'), last = text.rfind('/');
  if (first == std::string_view::npos || first == last)
    return failure("it is not of the form FILTER/BLOCK.OUTPUT/STATISTIC");
  Metric metric;
  metric.name = text;
  const Names filters = names_of(plan.filters);
  const auto wanted = text.substr(0, first);
  metric.filter = index_of(filters, wanted);
  if (metric.filter < 0) return failure("there is no filter " + in_quotes(wanted) + help(wanted, filters, "filters"));
  if (auto wrong = read_statistic(text.substr(last + 1), metric); !wrong.empty()) return failure(wrong);
  const auto subject = text.substr(first + 1, last - first - 1);
  const auto wrong = metric.quantity == MetricQuantity::nis        ? find_measurement(plan, subject, metric)
                     : metric.quantity == MetricQuantity::segments ? find_track(plan, subject, metric)
                                                                   : find_scored(plan, subject, metric);
  if (!wrong.empty()) return failure(wrong);
  return metric;
}

Parsed<Metric> read_metric(const Composition& composition, std::string_view text) {
  return read_metric(*plan_of(composition), text);
}

std::string show_in(Metric& metric, std::string_view text) {
  const auto unit = parse_unit(text);
  if (!unit) return unit.error();
  const auto own = parse_unit(metric.si_unit);
  if (own && !(own->dimension == unit->dimension))
    return "metric " + in_quotes(metric.name) + " is " + dimension_name(own->dimension) + "; " + in_quotes(text) +
           " is " + dimension_name(unit->dimension);
  metric.unit = text;
  return {};
}

}  // namespace binnacle::score
