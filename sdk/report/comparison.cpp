// SPDX-License-Identifier: Apache-2.0
#include "report/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "missing.hpp"

namespace binnacle::report {

namespace {

using results::FilterResults;
using results::Json;
using results::RunResults;

const FilterResults* filter_in(const RunResults& run, const std::string& name) {
  for (const auto& filter : run.filters)
    if (filter.name == name) return &filter;
  return nullptr;
}

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t most = 6;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i ? ", " : "") + names[i];
  return names.size() > most ? text + " and " + std::to_string(names.size() - most) + " more" : text;
}

// ---- figures

/// A figure of a summary and the unit beside it.
struct Figure {
  double value = 0;
  std::string unit;
};

/// Names in the order in which they come.
struct Figures {
  std::vector<std::string> names;
  std::map<std::string, Figure> values;
};

/// Of the computer, not of the estimate.
bool is_of_the_machine(const std::string& key) {
  return key == "filter_s" || key == "wall_s" || key == "seed" || key == "verdict";
}

/// What groups of figures are called in a summary and metrics leave out.
bool is_silent(const std::string& key) { return key == "reference" || key == "consistency" || key == "measurements"; }

void collect(const Json& value, const std::string& name, const std::string& unit, Figures& figures) {
  if (value.is_number()) {
    if (figures.values.emplace(name, Figure{value.get<double>(), unit}).second) figures.names.push_back(name);
    return;
  }
  if (!value.is_object()) return;
  const Json& own = at_or_null(value, "unit");
  for (const auto& [key, child] : value.items())
    if (!is_of_the_machine(key)) {
      const bool has_unit = own.is_string() && key != "n" && key != "dof";
      collect(child,
              is_silent(key) ? name
              : name.empty() ? key
                             : name + "/" + key,
              has_unit ? own.get<std::string>() : std::string(), figures);
    }
}

Json metric_json(const std::string& name, const std::vector<Figures>& figures) {
  Json values = Json::array(), differences = Json::array();
  std::string unit;
  std::optional<double> first;
  bool is_one_unit = true, is_first_run = true, has_unit = false;
  for (const auto& of : figures) {
    const auto found = of.values.find(name);
    const bool is_there = found != of.values.end() && std::isfinite(found->second.value);
    values.push_back(is_there ? Json(found->second.value) : Json(nullptr));
    if (is_there && has_unit) is_one_unit = is_one_unit && found->second.unit == unit;
    if (is_there && !has_unit) unit = found->second.unit, has_unit = true;
    differences.push_back(is_there && first && is_one_unit ? Json(found->second.value - *first) : Json(nullptr));
    if (is_there && is_first_run) first = found->second.value;
    is_first_run = false;
  }
  return {{"name", name},
          {"unit", is_one_unit ? unit : "each its own"},
          {"values", std::move(values)},
          {"differences", std::move(differences)}};
}

// ---- configs

std::string token(const std::string& key) {
  std::string text = "/";
  for (const char c : key) text += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
  return text;
}

void compare(const std::string& pointer, const std::vector<const Json*>& values, Json& list) {
  const bool is_everywhere = std::none_of(values.begin(), values.end(), [](const Json* value) { return !value; });
  const auto all = [&](auto is) { return is_everywhere && std::all_of(values.begin(), values.end(), is); };
  if (all([&](const Json* value) { return *value == *values.front(); })) return;
  if (all([](const Json* value) { return value->is_object(); })) {
    std::vector<std::string> keys;
    for (const Json* value : values)
      for (const auto& [key, child] : value->items())
        if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    for (const auto& key : keys) {
      std::vector<const Json*> children;
      for (const Json* value : values) children.push_back(value->contains(key) ? &value->at(key) : nullptr);
      compare(pointer + token(key), children, list);
    }
    return;
  }
  if (all([&](const Json* value) { return value->is_array() && value->size() == values.front()->size(); })) {
    for (std::size_t i = 0; i < values.front()->size(); ++i) {
      std::vector<const Json*> children;
      for (const Json* value : values) children.push_back(&value->at(i));
      compare(pointer + "/" + std::to_string(i), children, list);
    }
    return;
  }
  Json entry{{"pointer", pointer}, {"values", Json::array()}};
  for (const Json* value : values) entry["values"].push_back(value ? *value : Json(nullptr));
  list.push_back(std::move(entry));
}

// ---- what one has and another has not

/// Kinds of quantities, and the names of each in a filter's results.
std::vector<std::pair<const char*, std::vector<std::string>>> quantities(const FilterResults& filter) {
  std::vector<std::string> estimates, errors, measurements;
  for (const auto& estimate : filter.estimates) estimates.push_back(estimate.block + "." + estimate.output);
  for (const auto& error : filter.errors) errors.push_back(error.name);
  for (const auto& updates : filter.updates) measurements.push_back(updates.measurement);
  return {{"estimate", estimates}, {"error", errors}, {"measurement", measurements}};
}

std::optional<std::pair<double, double>> span_of(const FilterResults& filter) {
  if (filter.t.empty()) return {};
  return std::pair{filter.t.front(), filter.t.back()};
}

std::string seconds_text(double s) {
  std::string text = std::to_string(s);
  return text.substr(0, text.find('.') + 4);
}

}  // namespace

Comparison::Comparison(const std::vector<NamedRun>& runs, const std::vector<FilterPair>& pairs)
    : runs_(runs), json_(Json::object()) {
  if (runs.empty()) throw std::invalid_argument("there is no run to compare");
  match(pairs);
  add_runs();
  add_verdicts();
  add_metrics();
  add_config();
  add_lacks();
}

void Comparison::match(const std::vector<FilterPair>& pairs) {
  for (const auto& pair : pairs) {
    if (!filter_in(runs_[0].run, pair.first))
      throw std::invalid_argument("--pair " + pair.first + "=" + pair.other + ": '" + runs_[0].name +
                                  "', the first run, has no filter '" + pair.first + "'");
    if (std::none_of(runs_.begin() + 1, runs_.end(),
                     [&](const NamedRun& run) { return filter_in(run.run, pair.other) != nullptr; }))
      throw std::invalid_argument("--pair " + pair.first + "=" + pair.other +
                                  ": none of the runs after the first has a filter '" + pair.other + "'");
  }
  std::vector<std::set<std::string>> taken(runs_.size());
  for (const auto& filter : runs_[0].run.filters) {
    std::vector<std::string> of{filter.name};
    for (std::size_t i = 1; i < runs_.size(); ++i) {
      std::string name = filter.name;
      for (const auto& pair : pairs)
        if (pair.first == filter.name && filter_in(runs_[i].run, pair.other)) name = pair.other;
      of.push_back(filter_in(runs_[i].run, name) && taken[i].insert(name).second ? name : std::string());
    }
    filters_.push_back({filter.name, std::move(of)});
  }
  for (std::size_t i = 1; i < runs_.size(); ++i)
    for (const auto& filter : runs_[i].run.filters) {
      if (taken[i].contains(filter.name)) continue;
      std::vector<std::string> of(runs_.size());
      for (std::size_t j = i; j < runs_.size(); ++j)
        if (filter_in(runs_[j].run, filter.name) && taken[j].insert(filter.name).second) of[j] = filter.name;
      const bool is_new = !filter_in(runs_[0].run, filter.name);
      filters_.push_back({is_new ? filter.name : filter.name + " of " + runs_[i].name, std::move(of)});
    }
}

void Comparison::add_runs() {
  Json runs = Json::array(), filters = Json::array();  // of an ordered object a new key moves the others
  for (const auto& [name, folder, run] : runs_) {
    Json entry{{"name", name}, {"folder", folder}, {"title", at_or_null(run.config, "title")}};
    for (const char* key : {"command", "version", "seed", "created"}) {
      const Json& value = at_or_null(run.provenance, key);
      // Counters beyond 2^53 do not survive a script's numbers.
      entry[key] = value.is_number() ? Json(value.dump()) : value;
    }
    runs.push_back(std::move(entry));
  }
  for (const auto& [shown, of] : filters_) {
    Json entry{{"name", shown}, {"of", Json::array()}};
    for (const auto& name : of) entry["of"].push_back(name.empty() ? Json(nullptr) : Json(name));
    filters.push_back(std::move(entry));
  }
  json_["runs"] = std::move(runs);
  json_["filters"] = std::move(filters);
}

void Comparison::add_verdicts() {
  Json& list = json_["verdicts"] = Json::array();
  for (const auto& [shown, of] : filters_) {
    Json entry{{"filter", shown}, {"states", Json::array()}, {"codes", Json::array()}};
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      const Json& verdict = at_or_null(at_or_null(at_or_null(runs_[i].run.summary, "filters"), of[i]), "verdict");
      entry["states"].push_back(at_or_null(verdict, "state"));
      Json codes = Json::array();
      const Json& reasons = at_or_null(verdict, "reasons");
      if (reasons.is_array())
        for (const auto& reason : reasons) codes.push_back(at_or_null(reason, "code"));
      entry["codes"].push_back(std::move(codes));
    }
    list.push_back(std::move(entry));
  }
}

void Comparison::add_metrics() {
  Json& list = json_["metrics"] = Json::array();
  const auto add = [&](const std::vector<Figures>& figures) {
    std::vector<std::string> names;
    std::set<std::string> seen;
    for (const auto& of : figures)
      for (const auto& name : of.names)
        if (seen.insert(name).second) names.push_back(name);
    for (const auto& name : names) list.push_back(metric_json(name, figures));
  };
  for (const auto& [shown, of] : filters_) {
    std::vector<Figures> figures(runs_.size());
    for (std::size_t i = 0; i < runs_.size(); ++i)
      if (!of[i].empty())
        collect(at_or_null(at_or_null(runs_[i].run.summary, "filters"), of[i]), shown, "", figures[i]);
    add(figures);
  }
  std::vector<Figures> others(runs_.size());
  for (std::size_t i = 0; i < runs_.size(); ++i)
    for (const auto& [key, value] : runs_[i].run.summary.items())
      if (key != "filters" && !is_of_the_machine(key)) collect(value, key, "", others[i]);
  add(others);
}

/// A filter of another name stands at that of the first run.
void Comparison::add_config() {
  std::vector<Json> configs;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    configs.push_back(runs_[i].run.config);
    if (!at_or_null(configs.back(), "filters").is_object()) continue;
    Json& filters = configs.back()["filters"];
    for (const auto& [shown, of] : filters_)
      if (!of[i].empty() && of[i] != shown && filters.contains(of[i]) && !filters.contains(shown)) {
        const Json filter = filters[of[i]];
        filters[shown] = filter;
        filters.erase(of[i]);
      }
  }
  std::vector<const Json*> values;
  for (const Json& config : configs) values.push_back(&config);
  compare("", values, json_["config"] = Json::array());
}

void Comparison::add_lacks() {
  Json& list = json_["lacks"] = Json::array();
  for (const auto& [shown, of] : filters_) {
    std::vector<std::vector<std::string>> all(3);
    const char* kinds[3] = {};
    std::optional<std::pair<double, double>> first;
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (of[i].empty()) {
        list.push_back("'" + runs_[i].name + "' has no filter '" + shown +
                       "'; --pair FIRST=OTHER matches filters of "
                       "different names");
        continue;
      }
      const FilterResults& filter = *filter_in(runs_[i].run, of[i]);
      const auto has = quantities(filter);
      for (std::size_t k = 0; k < has.size(); ++k) {
        kinds[k] = has[k].first;
        for (const auto& name : has[k].second)
          if (std::find(all[k].begin(), all[k].end(), name) == all[k].end()) all[k].push_back(name);
      }
      const auto span = span_of(filter);
      if (!span) list.push_back("'" + runs_[i].name + "': filter '" + of[i] + "' has no estimates");
      if (span && first && (span->first > first->second || span->second < first->first))
        list.push_back("filter '" + of[i] + "' of '" + runs_[i].name + "' is of another time, " +
                       seconds_text(span->first) + " s to " + seconds_text(span->second) +
                       " s, than the first run's, " + seconds_text(first->first) + " s to " +
                       seconds_text(first->second) + " s: their curves do not lie over each other");
      if (!first) first = span;
    }
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      if (of[i].empty()) continue;
      const auto has = quantities(*filter_in(runs_[i].run, of[i]));
      for (std::size_t k = 0; k < has.size(); ++k) {
        std::vector<std::string> without;
        for (const auto& name : all[k])
          if (std::find(has[k].second.begin(), has[k].second.end(), name) == has[k].second.end())
            without.push_back(name);
        if (!without.empty())
          list.push_back("'" + runs_[i].name + "': filter '" + of[i] + "' has no " + kinds[k] + " " + listed(without) +
                         ", which others have");
      }
    }
  }
}

}  // namespace binnacle::report
