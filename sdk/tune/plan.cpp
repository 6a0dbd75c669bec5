// SPDX-License-Identifier: Apache-2.0
#include "tune/plan.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "binnacle/unit.hpp"
#include "score/sections.hpp"
#include "study/section.hpp"
#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;
using study::Section;

namespace {

constexpr double widest = 1e4;  // a factor to either side, where no bounds are given

/// The number, and the unit behind it; nothing where it is neither number nor quantity.
std::optional<Place> place_at(const Json& json, const std::string& pointer, int element) {
  if (json.is_number()) return Place{pointer, element, json.get<double>(), ""};
  if (!json.is_string()) return std::nullopt;
  const auto text = json.get<std::string>();
  const auto quantity = parse_quantity(text);
  if (!quantity) return std::nullopt;
  char* end = nullptr;
  Place place{pointer, element, std::strtod(text.c_str(), &end), end};
  place.unit.erase(0, std::min(place.unit.find_first_not_of(' '), place.unit.size()));
  return place;
}

class Reading {
 public:
  Reading(const Config& config, Diagnostics& diagnostics)
      : section_(config, diagnostics), config_(Json::parse(config.text())) {}

  const Section& section() const { return section_; }

  /// The numbers at a pointer of the config: one, or a list's.
  std::vector<Place> places(const std::string& pointer, const std::string& named_at) const {
    const Json* value = nullptr;
    try {
      value = section_.at(pointer);
    } catch (const Json::exception&) {
    }
    if (!value) {
      section_.key_error("B027", named_at,
                         "there is nothing at " + in_quotes(pointer) +
                             " of the config: a parameter is tuned from the value that stands there");
      return {};
    }
    std::vector<Place> places;
    const auto add = [&](const Json& json, int element) {
      if (auto place = place_at(json, pointer, element)) return places.push_back(*place), true;
      section_.key_error("B006", named_at, in_quotes(pointer) + " is not a number, quantity or list of such");
      return false;
    };
    if (!value->is_array()) {
      const Json::json_pointer at(pointer), list = at.parent_pointer();
      const bool is_element = config_.at(list).is_array();
      if (add(*value, is_element ? std::stoi(at.back()) : -1) && is_element) places.back().pointer = list.to_string();
      return places;
    }
    for (std::size_t i = 0; i < value->size(); ++i)
      if (!add((*value)[i], static_cast<int>(i))) return {};
    return places;
  }

  /// A quantity in the unit of the place.
  std::optional<double> quantity(const std::string& pointer, const Place& place) const {
    const Json* json = section_.at(pointer);
    if (!json) return std::nullopt;
    const auto given = place_at(*json, pointer, -1);
    const auto unit = parse_unit(place.unit.empty() ? "1" : place.unit);
    if (!given || !unit) {
      section_.error("B006", pointer, "a value of " + in_quotes(place.name()) + " is expected; found " + json->dump());
      return std::nullopt;
    }
    if (given->unit.empty() && place.unit.empty()) return given->value;
    const auto own = parse_unit(given->unit.empty() ? "1" : given->unit);
    if (place.unit.empty() || given->unit.empty() || !(own->dimension == unit->dimension)) {
      section_.error("B008", pointer,
                     in_quotes(place.name()) + " is in " +
                         (place.unit.empty() ? "SI, without a unit" : in_quotes(place.unit)) + "; found " +
                         json->dump());
      return std::nullopt;
    }
    return given->value * own->scale / unit->scale;
  }

  std::optional<double> number(const std::string& pointer, double above) const {
    const Json* json = section_.at(pointer);
    if (!json) return std::nullopt;
    if (json->is_number() && json->get<double>() > above) return json->get<double>();
    section_.error("B009", pointer, "a number above " + Json(above).dump() + " is expected; found " + json->dump());
    return std::nullopt;
  }

  void read(const std::string& pointer, std::vector<Parameter>& parameters) const {
    const std::string at = join_pointer("/tune/parameters", pointer);
    if (!section_.object(at)) return;
    section_.check_keys(at, {"start", "scale", "step", "bounds", "prior", "ties", "elements"}, "a parameter");
    std::vector<Place> places;
    bool has_start = false;
    if (const Json* start = section_.at(at + "/start")) {
      if (const auto place = place_at(*start, pointer, -1))
        places.push_back(*place);
      else
        section_.error("B006", at + "/start", "'start' is a number or quantity; found " + start->dump());
      has_start = true;
    } else {
      places = this->places(pointer, at);
    }
    const bool is_together = section_.choice(at + "/elements", {"each", "together"}).value_or("each") == "together";
    std::vector<Parameter> own;
    for (const Place& place : places) {
      if (is_together && !own.empty())
        own.front().ties.push_back(place);
      else
        own.emplace_back().place = place;
      own.back().has_start = has_start;
    }
    for (std::size_t i = 0; i < own.size(); ++i) {
      read_ties(at, i, own);
      read_scale(at, own[i]);
    }
    std::ranges::move(own, std::back_inserter(parameters));
  }

 private:
  void read_ties(const std::string& at, std::size_t index, std::vector<Parameter>& own) const {
    const Json* ties = section_.list(at + "/ties");
    if (!ties) return;
    for (std::size_t k = 0; k < ties->size(); ++k) {
      const std::string tie_at = join_pointer(at + "/ties", k);
      const auto pointer = section_.text(tie_at);
      if (!pointer) continue;
      const auto tied = places(*pointer, tie_at);
      if (own.size() == 1)
        own[0].ties.insert(own[0].ties.end(), tied.begin(), tied.end());
      else if (tied.size() == own.size())
        own[index].ties.push_back(tied[index]);
      else if (!tied.empty() && index == 0)
        section_.error("B009", tie_at,
                       "a tie of a list has as many numbers as the list, " + std::to_string(own.size()) + "; found " +
                           std::to_string(tied.size()));
    }
  }

  void read_scale(const std::string& at, Parameter& parameter) const {
    const Place& place = parameter.place;
    parameter.is_log = section_.choice(at + "/scale", {"log", "linear"}).value_or("log") == "log";
    if (parameter.is_log && place.value <= 0)
      return section_.key_error(
          "B009", at,
          in_quotes(place.name()) + " is " + Json(place.value).dump() +
              ", and on a log scale it starts above 0; \"scale\": \"linear\" with a \"step\" is the other");
    if (!parameter.is_log) {
      const auto step = quantity(at + "/step", place);
      if (!section_.at(at + "/step"))
        return section_.error("B010", at,
                              "missing key 'step': by how much a parameter on a linear scale is typically off");
      if (!step || *step <= 0) return section_.error("B009", at + "/step", "'step' is above 0");
      parameter.step = *step;
    }
    if (!parameter.ties.empty() && place.value == 0)
      return section_.key_error("B009", at, "ties keep their ratio to " + in_quotes(place.name()) + ", which is 0");
    read_bounds(at, parameter);
    read_prior(at, parameter);
  }

  void read_bounds(const std::string& at, Parameter& parameter) const {
    const double start = parameter.u_of(parameter.place.value);
    const double reach = parameter.is_log ? std::log(widest) : widest;
    parameter.lower = start - reach;
    parameter.upper = start + reach;
    const Json* bounds = section_.list(at + "/bounds");
    if (!bounds) return;
    if (bounds->size() != 2) return section_.error("B009", at + "/bounds", "'bounds' are [least, greatest]");
    const auto least = quantity(at + "/bounds/0", parameter.place), most = quantity(at + "/bounds/1", parameter.place);
    if (!least || !most) return;
    if (parameter.is_log && *least <= 0)
      return section_.error("B009", at + "/bounds/0", "on a log scale a bound is above 0");
    parameter.has_bounds = true;
    parameter.lower = parameter.u_of(*least);
    parameter.upper = parameter.u_of(*most);
    if (!(parameter.lower < start && start < parameter.upper))
      section_.error("B009", at + "/bounds",
                     "the start, " + shown_value(parameter.place, parameter.place.value).dump() +
                         ", lies between the bounds");
  }

  void read_prior(const std::string& at, Parameter& parameter) const {
    if (!section_.object(at + "/prior")) return;
    section_.check_keys(at + "/prior", {"value", parameter.is_log ? "factor" : "sigma"}, "a prior");
    const auto value = quantity(at + "/prior/value", parameter.place);
    if (!value) {
      if (!section_.at(at + "/prior/value"))
        section_.error("B010", at + "/prior", "missing key 'value': the most likely value before the data");
      return;
    }
    if (parameter.is_log && *value <= 0)
      return section_.error("B009", at + "/prior/value", "on a log scale a value is above 0");
    const auto sigma =
        parameter.is_log ? number(at + "/prior/factor", 1) : quantity(at + "/prior/sigma", parameter.place);
    if (!sigma || *sigma <= 0) {
      if (!sigma && !section_.at(at + (parameter.is_log ? "/prior/factor" : "/prior/sigma")))
        section_.error("B010", at + "/prior",
                       parameter.is_log ? "missing key 'factor': the factor to either side that is one sigma"
                                        : "missing key 'sigma': of the value");
      return;
    }
    parameter.prior =
        Parameter::Prior{parameter.u_of(*value), parameter.is_log ? std::log(*sigma) : *sigma / parameter.step};
  }

  const Section section_;
  const Json config_;
};

void read_objective(const Section& section, Plan& plan) {
  const Json* objective = section.at("/tune/objective");
  if (!objective) return;
  if (objective->is_object()) {
    section.check_keys("/tune/objective", {"metric", "withheld"}, "'objective'");
    if (const auto metric = section.text("/tune/objective/metric")) {
      plan.objective = Objective::metric;
      plan.metric = *metric;
    } else if (const auto word = section.choice("/tune/objective/withheld", {"nll", "rms"})) {
      plan.objective = *word == "nll" ? Objective::withheld_nll : Objective::withheld_rms;
    } else if (!section.at("/tune/objective/withheld") && !section.at("/tune/objective/metric")) {
      section.error("B010", "/tune/objective", "missing key 'metric' or 'withheld'");
    }
    return;
  }
  if (const auto word = section.choice("/tune/objective", {"likelihood", "withheld"}))
    plan.objective = *word == "likelihood" ? Objective::likelihood : Objective::withheld_nll;
}

std::vector<Member> members_of(const Section& section, const std::string& pointer, const std::filesystem::path& config,
                               const LoadOptions& load) {
  std::vector<Member> members;
  LoadOptions own = load;
  own.text.reset();                                                                           // of this config, too
  std::erase_if(own.sets, [](const std::string& set) { return set.starts_with("/tune/"); });  // of this config alone
  const Json* list = section.list(pointer);
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (const auto name = section.text(join_pointer(pointer, i)))
      members.push_back({config.parent_path() / *name, own});
  return members;
}

/// What is tuned stands in every config.
void check_members(const Plan& plan, Diagnostics& diagnostics) {
  for (const auto* members : {&plan.over, &plan.unseen})
    for (const Member& member : *members) {
      const Config config = score::load_config(member.config, member.load);
      const Json json = Json::parse(config.text());
      for (const Parameter& parameter : plan.parameters)
        if (!parameter.has_start && !json.contains(Json::json_pointer(parameter.place.pointer)))
          diagnostics.error("B027", {member.config.string(), 0, 0}, parameter.place.pointer,
                            "there is nothing here, and 'tune' has it as a parameter");
    }
}

void read_until(const Section& section, Plan& plan) {
  const auto text = section.text("/tune/until");
  if (!text) return;
  const bool is_relative = text->starts_with("start+");
  const auto time = parse_time(is_relative ? text->substr(6) : *text);
  if (!time) return section.error("B007", "/tune/until", time.error());
  if (plan.objective == Objective::metric)
    return section.error("B010", "/tune/until",
                         "a metric takes its time span from 'evaluate': \"evaluate\": {\"until\": …}");
  plan.until = When{*time, is_relative};
}

}  // namespace

double Parameter::u_of(double value) const { return is_log ? std::log(value) : value / step; }
double Parameter::value_of(double u) const { return is_log ? std::exp(u) : u * step; }

bool is_in(const Config& config) { return config.contains("/tune"); }

Plan read_plan(const std::filesystem::path& path, const LoadOptions& options) {
  const Config config = score::load_config(path, options);
  Diagnostics diagnostics;
  const Reading reading(config, diagnostics);
  const Section& section = reading.section();
  Plan plan;
  if (const auto title = section.text("/title")) plan.title = *title;
  if (!section.at("/tune"))
    section.key_error("B010", "",
                      "missing key 'tune': parameters by JSON pointer, {\"parameters\": "
                      "{\"/filters/ins/process/strapdown/gyro_noise\": {}}}");
  if (section.at("/tune") && section.object("/tune")) {
    section.check_keys("/tune", {"parameters", "objective", "over", "unseen", "until", "restarts"}, "'tune'");
    if (const Json* parameters = section.object("/tune/parameters"))
      for (const auto& [pointer, ignored] : parameters->items()) reading.read(pointer, plan.parameters);
    if (plan.parameters.empty() && !diagnostics.has_errors())
      section.key_error("B010", "/tune", "missing key 'parameters': what is tuned, by JSON pointer");
    read_objective(section, plan);
    read_until(section, plan);
    plan.over = members_of(section, "/tune/over", path, options);
    plan.unseen = members_of(section, "/tune/unseen", path, options);
    plan.restarts = static_cast<int>(section.whole_number("/tune/restarts", 0).value_or(0));
  }
  if (plan.over.empty()) plan.over.push_back({path, options});
  if (!diagnostics.has_errors()) check_members(plan, diagnostics);
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
  return plan;
}

Json shown_value(const Place& place, double value) {
  if (place.unit.empty()) return value;
  return Json(value).dump() + " " + place.unit;
}

Json patch_of(const std::vector<Parameter>& parameters, const std::vector<double>& u, const std::vector<bool>& is_in,
              const Json& config) {
  Json patch = Json::object();
  const auto set = [&](const Place& place, double value) {
    const Json::json_pointer at(place.pointer);
    if (place.element >= 0) {
      // A merge patch has lists whole.
      if (!patch.contains(at)) patch[at] = config.at(at);
      patch[at][as_size(place.element)] = shown_value(place, value);
    } else {
      patch[at] = shown_value(place, value);
    }
  };
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (!is_in[p]) continue;
    const double value = parameters[p].value_of(u[p]);
    set(parameters[p].place, value);
    for (const Place& tie : parameters[p].ties) set(tie, tie.value * value / parameters[p].place.value);
  }
  return patch;
}

std::vector<std::string> sets_of(const std::vector<Parameter>& parameters, const std::vector<double>& u,
                                 const Json& config) {
  const Json patch = patch_of(parameters, u, std::vector<bool>(parameters.size(), true), config);
  std::vector<std::string> sets;
  std::set<std::string> done;
  const auto add = [&](const Place& place) {
    if (!done.insert(place.pointer).second) return;
    sets.push_back(place.pointer + "=" + patch.at(Json::json_pointer(place.pointer)).dump());
  };
  for (const Parameter& parameter : parameters) {
    add(parameter.place);
    for (const Place& tie : parameter.ties) add(tie);
  }
  return sets;
}

}  // namespace binnacle::tune
