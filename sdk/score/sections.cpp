// SPDX-License-Identifier: Apache-2.0
// "evaluate", "record", and who reads what.
#include "score/sections.hpp"

#include <utility>

#include <nlohmann/json.hpp>

#include "binnacle/diagnostic.hpp"
#include "binnacle/unit.hpp"
#include "plan.hpp"
#include "references.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

void read_end(CompositionDraft& draft, const std::string& pointer, Time& time, bool& is_relative) {
  const auto when = draft.when(pointer);
  if (!when) return;
  time = when->time;
  is_relative = when->from_start;
}

void read_window(CompositionDraft& draft, const std::string& name, ScorePlan& plan) {
  const std::string pointer = join_pointer("/evaluate/windows", name);
  NamedWindow window;
  window.name = name;
  std::string span_pointer = pointer;
  if (draft.kind(pointer) == CompositionDraft::Kind::object) {
    draft.check_keys(pointer, {"filter", "span"}, "a window");
    span_pointer = join_pointer(pointer, "span");
    if (!draft.require_key(pointer, "span", name, "[from, to]")) return;
    const std::string filter_pointer = join_pointer(pointer, "filter");
    if (draft.kind(filter_pointer) != CompositionDraft::Kind::absent)
      if (const auto filter = draft.text(filter_pointer)) {
        const auto names = names_of(draft.filters());
        window.filter = index_of(names, *filter);
        if (window.filter < 0)
          draft.error("B027", filter_pointer, "there is no filter '" + *filter + "'" + suggestion(*filter, names));
      }
  }
  if (const auto span = draft.span(span_pointer)) {
    window.span = *span;
    plan.windows.push_back(std::move(window));
  }
}

void read_evaluate(CompositionDraft& draft, ScorePlan& plan) {
  if (draft.is_object("/evaluate", "'evaluate'")) {
    draft.check_keys("/evaluate", {"after", "until", "windows", "metrics"}, "'evaluate'");
    read_end(draft, "/evaluate/after", plan.span.from, plan.span.from_is_relative);
    read_end(draft, "/evaluate/until", plan.span.to, plan.span.to_is_relative);
    if (draft.is_object("/evaluate/windows", "'windows'"))
      for (const auto& name : draft.keys("/evaluate/windows")) read_window(draft, name, plan);
  }
  if (draft.is_object("/record", "'record'")) {
    draft.check_keys("/record", {"every"}, "'record'");
    if (const auto every = draft.time("/record/every")) plan.record_every = *every;
  }
}

/// A name, or {"metric": name, "unit": "mil"}.
void read_metric_at(CompositionDraft& draft, const std::string& pointer, ScorePlan& plan) {
  const bool is_object = draft.kind(pointer) == CompositionDraft::Kind::object;
  const std::string name_pointer = is_object ? join_pointer(pointer, "metric") : pointer;
  if (is_object) {
    draft.check_keys(pointer, {"metric", "unit"}, "a metric");
    if (!draft.require_key(pointer, "metric", "metric", "FILTER/BLOCK.OUTPUT/STATISTIC")) return;
  }
  const auto name = draft.text(name_pointer);
  if (!name) return;
  auto metric = read_metric(plan, *name);
  if (!metric) {
    // A variant of a study may lack what others have.
    if (draft.is_patched())
      plan.unknown_metrics.push_back({*name, name_pointer, metric.error()});
    else
      draft.error("B027", name_pointer, metric.error());
    return;
  }
  Metric shown = *metric;
  const std::string unit_pointer = join_pointer(pointer, "unit");
  if (is_object && draft.kind(unit_pointer) != CompositionDraft::Kind::absent)
    if (const auto unit = draft.text(unit_pointer))
      if (const auto wrong = show_in(shown, *unit); !wrong.empty())
        draft.error(parse_unit(*unit) ? "B007" : "B008", unit_pointer, wrong);
  plan.metrics.push_back(std::move(shown));
}

void read_metrics(CompositionDraft& draft, ScorePlan& plan) {
  const std::string all = "/evaluate/metrics";
  const auto kind = draft.kind(all);
  if (kind == CompositionDraft::Kind::absent) return;
  if (kind != CompositionDraft::Kind::list) return read_metric_at(draft, all, plan);
  for (std::size_t i = 0; i < draft.size(all); ++i) read_metric_at(draft, join_pointer(all, i), plan);
}

class Sections final : public Section {
 public:
  std::vector<std::string> keys() const override {
    return {"reference", "evaluate", "record", "study", "covariance", "metrics"};
  }
  std::vector<std::string> filter_keys() const override { return {"implied_states"}; }
  std::vector<std::pair<std::string, std::string>> renamed_keys() const override {
    return {{"readings", "implied_states"}};
  }
  std::vector<std::string> patches() const override { return {"/study/variants", "/study/dimensions/*"}; }

  std::shared_ptr<const SectionData> read(CompositionDraft& draft) const override {
    auto plan = std::make_shared<ScorePlan>();
    plan->filters = draft.filters();
    read_implied_states(draft, *plan);
    read_references(draft, *plan);
    read_evaluate(draft, *plan);
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
  return plan;
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

Config load_config(const std::filesystem::path& config, const LoadOptions& options) {
  return Config::load(config, with_sections(options));
}

}  // namespace binnacle::score
