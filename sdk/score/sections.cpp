// SPDX-License-Identifier: Apache-2.0
// "evaluate", "record", and who reads what.
#include "score/sections.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "binnacle/diagnostic.hpp"
#include "binnacle/state_block.hpp"
#include "binnacle/unit.hpp"
#include "plan.hpp"
#include "references.hpp"
#include "score/run.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

void read_end(const Reader& at, Time& time, bool& is_relative) {
  const auto when = at.when();
  if (!when) return;
  time = when->time;
  is_relative = when->from_start;
}

Place place_of(const Reader& at) { return {at.pointer(), at.key_origin()}; }

void read_window(const CompositionDraft& draft, const Reader& at, ScorePlan& plan) {
  NamedWindow window;
  window.name = at.key();
  const bool is_object = at.is_object();
  if (is_object) {
    at.check_keys({"filter", "span"}, "a window");
    if (!at.require("span", window.name, "[from, to]")) return;
    if (const auto filter = at["filter"].text()) {
      const auto names = names_of(draft.filters());
      window.filter = index_of(names, *filter);
      if (window.filter < 0)
        at["filter"].error("B027", "there is no filter '" + *filter + "'" + suggestion(*filter, names));
    }
  }
  if (const auto span = (is_object ? at["span"] : at).span()) {
    window.span = *span;
    window.place = place_of(at);
    plan.windows.push_back(std::move(window));
  }
}

void read_estimates(const Reader& at, ScorePlan& plan) {
  if (!at) return;
  const auto text = at.text();
  if (text == "live") plan.estimates = Estimates::live;
  if (text && text != "live" && text != "settled")
    at.error("B010", "'estimates' is \"settled\" or \"live\"; found " + at.shown());
}

void read_segments(const CompositionDraft& draft, const Reader& at, ScorePlan& plan) {
  if (!at || !at.is_object("'segments'")) return;
  SegmentSettings& segments = plan.segments;
  at.check_keys({"lengths", "every", "start_every", "attitude"}, "'segments'");
  if (const Reader lengths = at["lengths"]) {
    segments.lengths.clear();
    for (const Reader& length : lengths.elements("'lengths'"))
      if (const auto metres = length.number(parameter::number("lengths", "m").above(0)))
        segments.lengths.push_back(*metres);
    if (lengths.is_list() && lengths.children().empty())
      lengths.error("B006", "'lengths' needs one length at least, such as \"100 m\"");
  }
  if (const Reader every = at["every"])
    segments.every = every.time(parameter::time("every").above(0)).value_or(segments.every);
  if (const Reader start_every = at["start_every"])
    if (const auto count = start_every.integer(parameter::integer("start_every").at_least(1).at_most(1'000'000)))
      segments.start_every = static_cast<int>(*count);
  const Reader attitude = at["attitude"];
  segments.attitude = attitude.text().value_or("");
  if (segments.attitude.empty()) return;
  std::vector<std::string> names;
  for (const FilterInfo& filter : draft.filters())
    for (const BlockInfo& block : filter.blocks)
      if (block.declaration->kind == "attitude" && index_of(names, block.name) < 0) names.push_back(block.name);
  if (index_of(names, segments.attitude) < 0)
    attitude.error("B027", "no filter has an attitude '" + segments.attitude + "'" +
                               suggestion(segments.attitude, names) + " (attitudes: " + listed(names) + ")");
}

void read_evaluate(const CompositionDraft& draft, ScorePlan& plan) {
  const Reader evaluate = draft.at("/evaluate"), record = draft.at("/record");
  if (evaluate.is_object("'evaluate'")) {
    evaluate.check_keys({"after", "until", "windows", "metrics", "estimates", "segments"}, "'evaluate'");
    read_estimates(evaluate["estimates"], plan);
    read_segments(draft, evaluate["segments"], plan);
    plan.place = place_of(evaluate);
    read_end(evaluate["after"], plan.span.from, plan.span.from_is_relative);
    read_end(evaluate["until"], plan.span.to, plan.span.to_is_relative);
    const bool has_both = evaluate["after"] && evaluate["until"];
    if (has_both && plan.span.from_is_relative == plan.span.to_is_relative && plan.span.from >= plan.span.to)
      evaluate["until"].error("B024", "'until' is not later than 'after': nothing would be scored");
    for (const Reader& window : evaluate["windows"].members("'windows'")) read_window(draft, window, plan);
    for (const SmoothingPlan& smoothing : plan.smoothings) {
      std::vector<NamedWindow> copies;
      std::ranges::copy_if(plan.windows, std::back_inserter(copies),
                           [&](const NamedWindow& window) { return window.filter == smoothing.of; });
      for (NamedWindow& window : copies) window.filter = smoothing.as;
      plan.windows.insert(plan.windows.end(), copies.begin(), copies.end());
    }
  }
  if (record.is_object("'record'")) {
    record.check_keys({"every"}, "'record'");
    if (const auto every = record["every"].time()) plan.record_every = *every;
    if (plan.record_every < 0)
      record["every"].error("B009", "'every' is a time of at least 0 s; 0 s records every epoch");
  }
}

/// A name, or {"metric": name, "unit": "mil"}.
void read_metric_at(const CompositionDraft& draft, const Reader& at, ScorePlan& plan) {
  const bool is_object = at.is_object();
  if (is_object) {
    at.check_keys({"metric", "unit"}, "a metric");
    if (!at.require("metric", "metric", "FILTER/BLOCK.OUTPUT/STATISTIC")) return;
  }
  const Reader name_at = is_object ? at["metric"] : at;
  const auto name = name_at.text();
  if (!name) return;
  auto metric = read_metric(plan, *name);
  if (!metric) {
    // A variant of a study may lack what others have.
    if (draft.is_patched())
      plan.unknown_metrics.push_back({*name, name_at.pointer(), metric.error()});
    else
      name_at.error("B027", metric.error());
    return;
  }
  Metric shown = *metric;
  if (const auto unit = at["unit"].text())
    if (const auto wrong = show_in(shown, *unit); !wrong.empty())
      at["unit"].error(parse_unit(*unit) ? "B007" : "B008", wrong);
  plan.metrics.push_back(std::move(shown));
}

void read_metrics(const CompositionDraft& draft, ScorePlan& plan) {
  const Reader all = draft.at("/evaluate/metrics");
  if (all && !all.is_list()) return read_metric_at(draft, all, plan);
  for (const Reader& metric : all.children()) read_metric_at(draft, metric, plan);
}

/// "fixed_interval", or an object with a type; nothing where something is wrong.
std::optional<SmoothingPlan> read_type_of_smoother(const Reader& at) {
  const bool is_object = at.is_object();
  // A yes or no is the likely guess: what there is to choose from.
  if (const std::string shown = at.shown(); shown == "true" || shown == "false") {
    at.error("B006", "'smoother' is \"fixed_interval\" or an object with a type; found " + shown +
                         (shown == "true" ? "; did you mean \"fixed_interval\"? (smoothers: fixed_interval, fixed_lag)"
                                          : "; without a smoother, leave the key out"));
    return {};
  }
  if (is_object && !at["type"]) at.check_keys({"type", "iterations", "lag", "every"}, "'smoother'");
  if (is_object && !at.require("type", "smoother", "\"fixed_interval\" or \"fixed_lag\"")) return {};
  const Reader type_at = is_object ? at["type"] : at;
  const auto type = type_at.text();
  if (!type) return {};
  SmoothingPlan plan;
  if (*type == "fixed_interval") {
    if (!is_object) return plan;
    at.check_keys({"type", "iterations"}, "'smoother'");
    const auto iterations = at["iterations"].integer(parameter::integer("iterations").at_least(0).at_most(100));
    plan.iterations = static_cast<int>(iterations.value_or(0));
    return plan;
  }
  if (*type == "fixed_lag" && !is_object) {
    type_at.error("B010",
                  "a fixed lag needs its times: {\"type\": \"fixed_lag\", \"lag\": \"5 s\", \"every\": \"1 s\"}");
    return {};
  }
  if (*type == "fixed_lag") {
    at.check_keys({"type", "lag", "every"}, "'smoother'");
    if (!at.require("lag", "smoother", "a time, such as \"5 s\"")) return {};
    const auto lag = at["lag"].time(parameter::time("lag").at_least(0));
    const auto every = at["every"].time(parameter::time("every").above(0));
    if (lag) plan.lag = smooth::Lag{*lag, every.value_or(nanoseconds_per_second)};
    return plan;
  }
  type_at.error("B010", "there is no smoother '" + *type + "'" + suggestion(*type, {"fixed_interval", "fixed_lag"}) +
                            " (smoothers: fixed_interval, fixed_lag)");
  return {};
}

/// What is wrong with it is reported when it is read.
bool has_fixed_lag(const Reader& smoother) {
  if (!smoother.is_object()) return false;
  const Reader type = smoother["type"];
  return type && type.shown() == "the text \"fixed_lag\"";
}

/// What is smoothed is run again, and what a fixed lag emits comes once: a filter that it may feed cannot be smoothed.
void refuse_behind_lag(const CompositionDraft& draft, const Reader& at, int of) {
  for (const FilterInfo& filter : draft.filters()) {
    const std::string& name = draft.filters()[as_size(of)].name;
    if (filter.name == name || !has_fixed_lag(draft.at("/filters")[filter.name]["smoother"])) continue;
    const auto channel = std::ranges::find(draft.channels(), filter.name + ".smoothed", &ChannelInfo::name);
    if (channel == draft.channels().end()) continue;
    const auto feeds = [](const std::string& subscriber) { return !subscriber.starts_with("/sinks/"); };
    const auto fed = std::ranges::find_if(channel->subscribers, feeds);
    if (fed == channel->subscribers.end()) continue;
    return at.error("B010", "filter '" + name + "' cannot be smoothed: a smoother runs the data again, and what '" +
                                channel->name + "' emits to " + *fed +
                                " comes only once; smooth it in a run of its own");
  }
}

void read_smoother(const CompositionDraft& draft, const Reader& at, int of, ScorePlan& plan) {
  auto smoothing = read_type_of_smoother(at);
  if (!smoothing) return;
  refuse_behind_lag(draft, at, of);
  const Reader estimates = draft.at("/evaluate/estimates");
  if (plan.filters[as_size(of)].history > 0 && estimates && estimates.text() == "live")
    at.error("B010", "what is smoothed are settled estimates, and 'evaluate' asks for live ones of '" +
                         plan.filters[as_size(of)].name + "': smooth it in a run of its own");
  FilterInfo smoothed = plan.filters[as_size(of)];
  smoothed.name += ".smoothed";
  if (index_of(names_of(plan.filters), smoothed.name) >= 0)
    return at.error("B002", "there is a filter '" + smoothed.name + "' already, and what is smoothed has that name");
  smoothing->of = of;
  smoothing->as = static_cast<int>(plan.filters.size());
  plan.smoothings.push_back(*smoothing);
  plan.filters.push_back(std::move(smoothed));
  plan.implied_states.emplace_back();
  const std::size_t references = plan.references.size();
  for (std::size_t r = 0; r < references; ++r) {
    ReferencePlan reference = plan.references[r];
    if (reference.filter != of || reference.implied_state >= 0) continue;
    reference.filter = plan.smoothings.back().as;
    plan.references.push_back(std::move(reference));
  }
}

void read_smoothers(const CompositionDraft& draft, ScorePlan& plan) {
  for (std::size_t f = 0; f < draft.filters().size(); ++f)
    if (const Reader at = draft.at("/filters")[draft.filters()[f].name]["smoother"])
      read_smoother(draft, at, static_cast<int>(f), plan);
}

/// By block, in the unit of its error.
Limits limits_of(const Reader& all, const FilterInfo& filter) {
  Limits limits;
  if (!all.is_object("'limits'")) return limits;
  for (const Reader& at : all.members("'limits'")) {
    const auto block = std::ranges::find(filter.blocks, at.key(), &BlockInfo::name);
    if (block == filter.blocks.end()) {
      at.key_error("B027", "there is no block '" + at.key() + "'" + suggestion(at.key(), names_of(filter.blocks)));
      continue;
    }
    std::set<std::string> units;
    for (const auto& component : block->declaration->error) units.insert(component.unit);
    if (units.size() != 1)
      at.error("B007", "the components of '" + at.key() + "' have no unit in common, so they keep three sigma");
    else if (const auto limit = at.number(parameter::number(at.key(), *units.begin()).above(0)))
      limits[at.key()] = *limit;
  }
  return limits;
}

void read_limits(const CompositionDraft& draft, ScorePlan& plan) {
  for (const FilterInfo& filter : draft.filters()) {
    const Reader limits = draft.at("/filters")[filter.name]["limits"];
    plan.limits.push_back(limits ? limits_of(limits, filter) : Limits());
  }
}

class Sections final : public Section {
 public:
  std::vector<std::string> keys() const override {
    return {"reference", "evaluate", "record", "study", "covariance", "tune", "metrics"};
  }
  std::vector<std::string> filter_keys() const override { return {"implied_states", "smoother", "limits"}; }
  std::vector<std::string> filter_channels(const Reader& filter) const override {
    return has_fixed_lag(filter["smoother"]) ? std::vector<std::string>{"smoothed"} : std::vector<std::string>();
  }
  RenamedKeys renamed_keys() const override { return {{"readings", "implied_states"}}; }
  std::vector<std::string> patches() const override { return {"/study/variants", "/study/dimensions/*"}; }

  std::shared_ptr<const SectionData> read(CompositionDraft& draft) const override {
    auto plan = std::make_shared<ScorePlan>();
    plan->filters = draft.filters();
    const ParameterValue origin = draft.at("/origin").value(parameter::origin());
    if (origin.type == ParameterValue::Type::object && !draft.has_errors())
      plan->local.emplace(lla_of(Parameters(origin)));
    read_implied_states(draft, *plan);
    read_references(draft, *plan);
    read_smoothers(draft, *plan);
    read_limits(draft, *plan);
    read_evaluate(draft, *plan);
    plan->motion = read_motion_fields(draft);
    if (!draft.has_errors()) read_metrics(draft, *plan);
    return plan;
  }
};

}  // namespace

std::string ScorePlan::explain(int filter) const {
  auto list = nlohmann::ordered_json::array();
  const auto& info = filters[as_size(filter)];
  for (const auto& implied_state : implied_states[as_size(filter)])
    list.push_back({{"name", implied_state.value.name},
                    {"measurement", info.measurements[as_size(implied_state.measurement)].name},
                    {"block", info.blocks[as_size(implied_state.block)].name}});
  return list.empty() ? std::string() : nlohmann::ordered_json{{"implied_states", list}}.dump();
}

std::shared_ptr<const ScorePlan> plan_of(const Composition& composition) {
  for (const auto& section : composition.sections())
    if (auto plan = std::dynamic_pointer_cast<const ScorePlan>(section)) return plan;
  auto plan = std::make_shared<ScorePlan>();
  plan->filters = composition.filters();
  plan->implied_states.resize(plan->filters.size());
  plan->limits.resize(plan->filters.size());
  return plan;
}

const std::vector<FilterInfo>& filters_of(const Composition& composition) {
  for (const auto& section : composition.sections())
    if (const auto plan = std::dynamic_pointer_cast<const ScorePlan>(section)) return plan->filters;
  return composition.filters();
}

std::vector<UnknownMetric> unknown_metrics(const Composition& composition) {
  return plan_of(composition)->unknown_metrics;
}

LoadOptions with_sections(LoadOptions options) {
  for (const auto& section : options.sections)
    if (std::dynamic_pointer_cast<const Sections>(section)) return options;
  options.sections.push_back(std::make_shared<const Sections>());
  return options;
}

std::shared_ptr<const Composition> load(const std::filesystem::path& config, const LoadOptions& options) {
  return Composition::load(config, with_sections(options));
}

std::shared_ptr<const Composition> parse(std::string_view text, const std::filesystem::path& name,
                                         const LoadOptions& options) {
  return Composition::parse(text, name, with_sections(options));
}

std::shared_ptr<const Composition> compose(const Config& config, const LoadOptions& options) {
  return Composition::of(config, with_sections(options));
}

Config load_config(const std::filesystem::path& config, const LoadOptions& options) {
  return Config::load(config, with_sections(options));
}

std::vector<std::string> by_jacobians(const nlohmann::ordered_json& config, const std::string& filter) {
  const auto& its = config.at("filters").at(filter);
  const std::string at = join_pointer("/filters", filter);
  std::vector<std::string> sets;
  if (its.contains("propagation")) sets.push_back(at + "/propagation=\"ekf\"");
  if (its.contains("measurements"))
    for (const auto& [name, measurement] : its.at("measurements").items())
      if (measurement.contains("update")) sets.push_back(join_pointer(at + "/measurements", name) + "/update=\"ekf\"");
  return sets;
}

}  // namespace binnacle::score
