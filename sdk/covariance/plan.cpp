// SPDX-License-Identifier: Apache-2.0
#include "plan.hpp"

#include "binnacle/unit.hpp"
#include "score/sections.hpp"
#include "study/section.hpp"
#include "wording/wording.hpp"

namespace binnacle::covariance {

namespace {

using study::Json;
using study::Section;
using wording::in_quotes;
using wording::listed;
using wording::suggestion;

constexpr const char* place = "/covariance";

std::string under(const std::string& key) { return join_pointer(place, key); }

Time read_time(const Section& section, const std::string& pointer) {
  const auto text = section.text(pointer);
  if (!text) {
    if (!section.at(pointer))
      section.error("B010", pointer, "missing key " + in_quotes(pointer.substr(pointer.rfind('/') + 1)));
    return 0;
  }
  const auto time = parse_time(*text);
  if (time && *time > 0) return *time;
  section.error("B009", pointer, time ? "expected a time above zero" : time.error());
  return 0;
}

/// A plain number is SI; text has a unit of the field's dimension.
double read_value(const Section& section, const std::string& pointer, const FieldSpec& field) {
  const Json& value = *section.at(pointer);
  if (value.is_number()) return value.get<double>();
  if (const auto text = section.text(pointer)) {
    const auto quantity = parse_quantity(*text);
    if (!quantity) {
      section.error("B008", pointer, quantity.error());
    } else if (const auto unit = parse_unit(field.unit); unit && !(unit->dimension == quantity->dimension)) {
      section.error("B007", pointer, in_quotes(field.name) + " is " + dimension_name(unit->dimension));
    } else {
      return quantity->value;
    }
  }
  return 0;
}

std::vector<Feed> read_feeds(const Section& section, const Composition& composition) {
  std::vector<Feed> feeds;
  const std::string pointer = under("channels");
  const Json* channels = section.object(pointer);
  if (!channels) return feeds;
  std::vector<std::string> names;
  for (const auto& channel : composition.channels()) names.push_back(channel.name);
  for (const auto& [name, settings] : channels->items()) {
    const std::string at = join_pointer(pointer, name);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      section.key_error("B020", at,
                        "there is no channel " + in_quotes(name) + suggestion(name, names) +
                            " (channels: " + listed(names) + ")");
      continue;
    }
    if (!section.object(at)) continue;
    section.check_keys(at, {"interval", "values"}, "a channel");
    Feed feed;
    feed.channel = name;
    feed.interval = read_time(section, join_pointer(at, "interval"));
    const auto& fields = composition.channels()[static_cast<std::size_t>(found - names.begin())].declaration->fields;
    std::vector<std::string> known;
    for (const auto& field : fields) {
      if (field.is_per_row) continue;
      known.push_back(field.name);
      feed.is_of_intervals |= field.kind != FieldKind::level;
      const std::string value = join_pointer(join_pointer(at, "values"), field.name);
      feed.values.push_back(section.at(value) ? read_value(section, value, field) : 0.0);
    }
    if (section.object(join_pointer(at, "values")))
      section.check_keys(join_pointer(at, "values"), known, "the channel's fields");
    feeds.push_back(std::move(feed));
  }
  return feeds;
}

/// The filter's "implied states", which the composition has checked, and what else they are to be called.
std::vector<NamedImpliedState> implied_states_of(const Json& config, const std::string& filter) {
  std::vector<NamedImpliedState> implied_states;
  const auto object = [&config](const std::string& pointer) -> const Json* {
    const Json::json_pointer at(pointer);
    return config.contains(at) && config.at(at).is_object() ? &config.at(at) : nullptr;
  };
  if (const Json* list = object(join_pointer(join_pointer("/filters", filter), "implied_states")))
    for (const auto& [name, settings] : list->items())
      implied_states.push_back(
          {name, settings.at("measurement").get<std::string>(), settings.at("block").get<std::string>()});
  if (const Json* list = object(under("outputs")))
    for (const auto& [name, implied_state] : list->items())
      for (std::size_t i = 0; i < implied_states.size(); ++i)
        if (implied_state.is_string() && implied_states[i].name == implied_state.get<std::string>()) {
          implied_states.push_back({name, implied_states[i].measurement, implied_states[i].block});
          break;
        }
  return implied_states;
}

void check_outputs(const Section& section, const std::vector<NamedImpliedState>& implied_states) {
  const Json* list = section.object(under("outputs"));
  if (!list) return;
  std::vector<std::string> names;
  for (const auto& implied_state : implied_states)
    if (!list->contains(implied_state.name)) names.push_back(implied_state.name);
  for (const auto& [name, implied_state] : list->items()) {
    const std::string at = join_pointer(under("outputs"), name);
    const auto wanted = section.text(at);
    if (wanted && std::find(names.begin(), names.end(), *wanted) == names.end())
      section.error("B015", at,
                    "the filter has no implied state " + in_quotes(*wanted) + suggestion(*wanted, names) +
                        " (implied states: " + listed(names) + ")");
  }
}

std::vector<InitialTie> read_initial(const Section& section, const FilterInfo& truth) {
  std::vector<InitialTie> ties;
  const Json* list = section.object(under("initial"));
  if (!list) return ties;
  std::vector<std::string> names;
  for (const auto& block : truth.blocks) names.push_back(block.name);
  const auto dof_of = [&](const std::string& at, const std::string& name) -> Eigen::Index {
    for (const auto& block : truth.blocks)
      if (block.name == name) return block.declaration->dof();
    section.error("B015", at,
                  "there is no block " + in_quotes(name) + suggestion(name, names) + " (blocks: " + listed(names) +
                      ")");
    return 0;
  };
  for (const auto& [name, settings] : list->items()) {
    const std::string at = join_pointer(under("initial"), name);
    if (!section.object(at)) continue;
    section.check_keys(at, {"of", "by"}, "what an initial error is made of");
    InitialTie tie{name, section.text(join_pointer(at, "of")).value_or(""), {}};
    if (tie.of.empty()) section.error("B010", at, "missing key 'of': a block");
    const Eigen::Index rows = dof_of(at, name), columns = tie.of.empty() ? 0 : dof_of(join_pointer(at, "of"), tie.of);
    if (rows == 0 || columns == 0) continue;
    tie.by.resize(rows, columns);
    const Json* by = section.list(join_pointer(at, "by"));
    bool is_matrix = by && static_cast<Eigen::Index>(by->size()) == rows;
    for (Eigen::Index i = 0; is_matrix && i < rows; ++i) {
      const Json& row = by->at(static_cast<std::size_t>(i));
      is_matrix = row.is_array() && static_cast<Eigen::Index>(row.size()) == columns &&
                  std::all_of(row.begin(), row.end(), [](const Json& value) { return value.is_number(); });
      for (Eigen::Index j = 0; is_matrix && j < columns; ++j)
        tie.by(i, j) = row.at(static_cast<std::size_t>(j)).get<double>();
    }
    if (!is_matrix)
      section.error("B013", join_pointer(at, "by"),
                    "'by' is a matrix of numbers, " + std::to_string(rows) + " rows of " + std::to_string(columns));
    else
      ties.push_back(std::move(tie));
  }
  return ties;
}

/// What a filter makes of its residuals cannot be known without data. `pointer`: of the filter, or of what is merged over it.
void refuse_adaptive_noise(const Section& section, const std::string& filter_pointer) {
  const std::string pointer = join_pointer(filter_pointer, "measurements");
  const Json* measurements = section.at(pointer);
  if (!measurements || !measurements->is_object()) return;
  for (const auto& [name, settings] : measurements->items())
    if (settings.is_object() && settings.contains("noise") && !settings.at("noise").is_null())
      section.key_error(
          "B094", join_pointer(join_pointer(pointer, name), "noise"),
          "adaptive noise is estimated from residuals, and a covariance analysis has no data: take it out, "
          "or run a study");
}

struct Words {
  std::string filter, name, statistic;
};

Words words_of(const std::string& text) {
  const auto first = text.find('/'), last = text.rfind('/');
  if (first == std::string::npos || first == last) return {};
  return {text.substr(0, first), text.substr(first + 1, last - first - 1), text.substr(last + 1)};
}

constexpr const char* shape =
    "FILTER/BLOCK.COMPONENT/STATISTIC with sigma, 'own sigma' (each also 'at 100 s') or settled";

Parsed<Request> read_request(const std::string& text) {
  const Words words = words_of(text);
  Request request;
  request.name = words.name;
  std::string word = words.statistic;
  if (const auto at = word.find(" at "); at != std::string::npos) {
    const auto time = parse_time(word.substr(at + 4));
    if (!time) return Parsed<Request>::failure(time.error());
    request.at = *time;
    word.resize(at);
  }
  if (word == "sigma")
    request.statistic = Statistic::sigma;
  else if (word == "own sigma")
    request.statistic = Statistic::own_sigma;
  else if (word == "settled" && request.at == no_time)
    request.statistic = Statistic::settled;
  else
    return Parsed<Request>::failure(in_quotes(text) + " is not a metric of a covariance analysis: " + shape);
  return request;
}

std::vector<std::string> component_names(const StateBlockDeclaration& block) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  };
  for (const auto& error : block.error) add(error.name);
  for (const auto& norm : block.norms) add(norm.name);
  for (const auto& output : block.outputs) add(output.name);
  return names;
}

/// The config with nothing but what moves the filter, the truth beside it, the sources without their errors.
Json error_free_root(const Section& section, const Json& resolved, const std::string& filter,
                     const std::string& truth) {
  Json root = resolved;
  for (const char* key : {"reference", "evaluate", "sinks"}) root.erase(key);
  if (const Json* patch = section.at(under("error_free"))) root["sources"].merge_patch(*patch);
  if (const Json* patch = section.at(under("truth"))) {
    root["filters"][truth] = root["filters"][filter];
    root["filters"][truth].merge_patch(*patch);
  }
  return root;
}

}  // namespace

SubjectName subject_named(const std::string& name, const std::vector<NamedImpliedState>& implied_states) {
  SubjectName subject;
  const auto dot = name.find('.');
  subject.block = name.substr(0, dot);
  if (dot != std::string::npos) subject.component = name.substr(dot + 1);
  for (const auto& implied_state : implied_states)
    if (implied_state.name == subject.block) subject.implied_state = implied_state;
  if (subject.implied_state) subject.block = subject.implied_state->block;
  return subject;
}

std::optional<Component> component_named(const StateBlockDeclaration& block, const std::string& name) {
  if (name.empty()) return Component{{0}, -1};
  for (std::size_t i = 0; i < block.error.size(); ++i)
    if (block.error[i].name == name) return Component{{static_cast<int>(i)}, -1};
  for (const auto& norm : block.norms)
    if (norm.name == name) return Component{norm.components, -1};
  for (std::size_t i = 0; i < block.outputs.size(); ++i)
    if (block.outputs[i].name == name) return Component{{}, static_cast<int>(i)};
  return std::nullopt;
}

int runs_of(const Config& config) {
  Diagnostics ignored;
  return static_cast<int>(Section(config, ignored).whole_number(under("runs"), 1).value_or(1));
}

Parsed<score::Metric> read_metric(const Composition& composition, std::string_view text) {
  const Words words = words_of(std::string(text));
  const auto request = read_request(std::string(text));
  if (!request) return Parsed<score::Metric>::failure(request.error());
  const auto& filters = composition.filters();
  const auto filter =
      std::find_if(filters.begin(), filters.end(), [&](const auto& info) { return info.name == words.filter; });
  if (filter == filters.end()) return Parsed<score::Metric>::failure("there is no filter " + in_quotes(words.filter));
  score::Metric metric;
  metric.name = text;
  metric.filter = static_cast<int>(filter - filters.begin());
  metric.quantity = score::MetricQuantity::sigma;
  const auto known = implied_states_of(Json::parse(composition.config()), words.filter);
  const SubjectName subject = subject_named(words.name, known);
  std::vector<std::string> names;
  for (const auto& block : filter->blocks) names.push_back(block.name);
  const auto found = std::find(names.begin(), names.end(), subject.block);
  if (found == names.end()) {
    for (const auto& implied_state : known) names.push_back(implied_state.name);
    return Parsed<score::Metric>::failure("filter " + in_quotes(words.filter) + " has no block or implied state " +
                                          in_quotes(subject.block) + suggestion(subject.block, names) +
                                          " (there are: " + listed(names) + ")");
  }
  const auto& block = *filter->blocks[static_cast<std::size_t>(found - names.begin())].declaration;
  if (subject.component.empty() && block.error.size() > 1)
    return Parsed<score::Metric>::failure("block " + in_quotes(subject.block) +
                                          " has several error components: " + shape);
  const auto component = component_named(block, subject.component);
  if (!component || (subject.implied_state && component->output >= 0)) {
    const auto components = component_names(block);
    return Parsed<score::Metric>::failure(in_quotes(words.name) + " is not a component of block " +
                                          in_quotes(subject.block) + suggestion(subject.component, components) +
                                          " (it has: " + listed(components) + ")");
  }
  std::string display = block.error_display_unit;
  if (component->output >= 0) {
    const auto& output = block.outputs[static_cast<std::size_t>(component->output)];
    metric.si_unit = output.unit;
    display = output.display_unit;
  } else {
    metric.si_unit = block.error[static_cast<std::size_t>(component->errors.front())].unit;
  }
  if (request->statistic == Statistic::settled) metric.si_unit = "s";
  metric.unit = request->statistic != Statistic::settled && !display.empty() ? display : metric.si_unit;
  return metric;
}

Request request_of(const std::string& metric) { return *read_request(metric); }

namespace {

/// The analysed composition, with the truth's filter beside its own; null with an error where it cannot be composed.
std::shared_ptr<const Composition> compose_error_free(const Section& section, const Config& config,
                                                      const std::filesystem::path& path, const LoadOptions& options,
                                                      const std::string& name, const std::string& truth) {
  LoadOptions plugins;  // the config is resolved: no more of the options
  plugins.linked_plugins = options.linked_plugins;
  plugins.plugin_folders = options.plugin_folders;
  try {
    return score::parse(error_free_root(section, Json::parse(config.text()), name, truth).dump(), path, plugins);
  } catch (const Error& error) {
    const bool has_truth = section.at(under("truth")) != nullptr;
    for (const auto& item : error.diagnostics().items()) {
      const bool is_of_source = item.pointer.starts_with("/sources");
      section.error(item.code, is_of_source || !has_truth ? under("error_free") : under("truth"),
                    (is_of_source ? "with the sources free of errors: "
                                  : "with the truth merged over filter " + in_quotes(name) + ": ") +
                        item.message);
    }
    return nullptr;
  }
}

}  // namespace

Plan read_plan(const Config& config, const std::filesystem::path& path, const LoadOptions& options,
               const std::shared_ptr<const Composition>& composition, Diagnostics& diagnostics) {
  const Section section(config, diagnostics);
  Plan plan;
  plan.composition = composition;
  if (!section.object(place)) {
    section.error("B010", place, "missing key 'covariance': analysed filter and duration");
    return plan;
  }
  section.check_keys(place,
                     {"filter", "duration", "channels", "error_free", "runs", "outputs", "truth", "initial", "metrics",
                      "table", "tables"},
                     "'covariance'");
  std::vector<std::string> names;
  for (const auto& filter : composition->filters()) names.push_back(filter.name);
  const std::string name = section.text(under("filter")).value_or(names.front());
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    section.error("B027", under("filter"), "there is no filter " + in_quotes(name) + suggestion(name, names));
    return plan;
  }
  plan.filter = plan.truth = static_cast<int>(found - names.begin());
  const bool is_fed = section.at(under("channels")) != nullptr;
  if (is_fed || section.at(under("duration"))) plan.duration = read_time(section, under("duration"));
  if (is_fed) plan.feeds = read_feeds(section, *composition);
  if (is_fed && plan.feeds.empty() && !diagnostics.has_errors())
    section.error("B010", under("channels"), "no channel emits; without 'channels' the config's sources are run");
  plan.runs = static_cast<int>(section.whole_number(under("runs"), 1).value_or(1));
  for (const char* key : {"error_free", "runs"})
    if (is_fed && section.at(under(key)))
      section.key_error("B012", under(key),
                        in_quotes(key) +
                            " applies to sources, but with 'channels' no source is run: remove one of the two");
  plan.implied_states = implied_states_of(Json::parse(config.text()), name);
  check_outputs(section, plan.implied_states);
  refuse_adaptive_noise(section, join_pointer("/filters", name));
  refuse_adaptive_noise(section, under("truth"));
  section.object(under("error_free"));
  const bool has_truth = section.object(under("truth")) != nullptr;
  if (diagnostics.has_errors()) return plan;
  const std::string truth = name + " (truth)";
  const auto error_free = compose_error_free(section, config, path, options, name, truth);
  if (!error_free) return plan;
  plan.composition = error_free;
  const auto& filters = plan.composition->filters();
  for (std::size_t f = 0; f < filters.size(); ++f) {
    if (filters[f].name == name) plan.filter = plan.truth = static_cast<int>(f);
    if (has_truth && filters[f].name == truth) plan.truth = static_cast<int>(f);
  }
  plan.initial = read_initial(section, filters[static_cast<std::size_t>(plan.truth)]);
  return plan;
}

}  // namespace binnacle::covariance
