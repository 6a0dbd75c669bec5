// SPDX-License-Identifier: Apache-2.0
#include "tune/tune.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <random>
#include <utility>

#include <Eigen/Core>

#include "algebra/decompositions.hpp"
#include "judge.hpp"
#include "runs.hpp"
#include "search.hpp"
#include "wording/short_number.hpp"
#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;

namespace {

/// Known no better than by a factor of e, or a step: that is not known.
constexpr double undetermined_sigma = 1.0;
constexpr double restart_reach = 2.302585092994046;  // a factor of 10

enum class State { determined, undetermined, at_bound, without_effect };

/// To six digits: what is more says nothing, and nobody reads it.
double rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return std::strtod(text, nullptr);
}

const char* state_word(State state) {
  switch (state) {
    case State::determined: return "determined";
    case State::undetermined: return "not determined";
    case State::at_bound: return "at its bound";
    case State::without_effect: return "without effect";
  }
  return "";
}

/// One start, with runs and a search of its own.
struct Try {
  Try(const Plan& plan, TuneOptions of_it, const Runs& from, const std::vector<Law>& laws)
      : options(std::move(of_it)), runs(from), search(plan, options, runs, laws) {}

  void go(const std::vector<bool>& is_free) {
    try {
      found = search.from(found.u, is_free);
    } catch (const FilterError& error) {
      failure = error.diagnostics().items().front().message;
    }
  }

  TuneOptions options;
  Runs runs;
  Search search;
  Found found;
  std::string failure;
};

class Tuner {
 public:
  Tuner(const Plan& plan, const TuneOptions& options)
      : plan_(plan),
        options_(options),
        first_runs_(plan, options),
        runs_(&first_runs_),
        states_(plan.parameters.size(), State::determined) {
    for (const Parameter& parameter : plan.parameters) start_.push_back(parameter.u_of(parameter.place.value));
  }

  Json tune() {
    find_laws();
    tries_.push_back(std::make_unique<Try>(plan_, options_, *runs_, laws_));
    use(*tries_.front());
    if (has_free()) {
      found_ = search_->from(start_, free());
      restart();
      while (hold_what_is_open() && has_free()) {
        auto u = found_.u;
        for (std::size_t p = 0; p < u.size(); ++p)
          if (states_[p] != State::determined && states_[p] != State::at_bound) u[p] = start_[p];
        found_ = search_->from(u, free());
      }
    }
    if (!has_free()) {
      const auto bounds = found_.u;
      found_.u = start_;
      for (std::size_t p = 0; p < bounds.size(); ++p)
        if (states_[p] == State::at_bound) found_.u[p] = bounds[p];
      found_.free.clear();
    }
    return report();
  }

 private:
  std::vector<bool> free() const {
    std::vector<bool> is_free;
    for (const State state : states_) is_free.push_back(state == State::determined);
    return is_free;
  }
  void use(Try& one) {
    runs_ = &one.runs;
    search_ = &one.search;
    found_ = std::move(one.found);
  }
  bool has_free() const { return std::ranges::find(states_, State::determined) != states_.end(); }

  void find_laws() {
    laws_.assign(plan_.parameters.size(), Law::other);
    if (plan_.objective != Objective::likelihood) return;
    laws_ = runs_->laws();
    for (std::size_t p = 0; p < laws_.size(); ++p) {
      if (laws_[p] != Law::none) continue;
      states_[p] = State::without_effect;
      undetermined_.push_back({{"direction", {{plan_.parameters[p].place.name(), 1.0}}},
                               {"text", plan_.parameters[p].place.name() + ": nothing in the filter depends on it"}});
    }
  }

  /// From other starts, each with runs of its own; the best end wins.
  void restart() {
    std::mt19937_64 random(options_.seed);
    std::mutex is_telling;
    for (int k = 0; k < plan_.restarts; ++k) {
      auto u = start_;
      for (std::size_t p = 0; p < u.size(); ++p) {
        const Parameter& parameter = plan_.parameters[p];
        const double reach = restart_reach * (2 * std::generate_canonical<double, 53>(random) - 1);
        if (states_[p] == State::determined) u[p] = std::clamp(u[p] + reach, parameter.lower, parameter.upper);
      }
      TuneOptions options = options_;
      options.on_round = [this, k, &is_telling](const std::string& line) {
        const std::lock_guard lock(is_telling);
        options_.on_round("restart " + std::to_string(k + 1) + ": " + line);
      };
      tries_.push_back(std::make_unique<Try>(plan_, std::move(options), *runs_, laws_));
      tries_.back()->found.u = std::move(u);
    }
    study::in_parallel(options_.jobs, tries_.size() - 1, [&](std::size_t k) { tries_[k + 1]->go(free()); });
    for (std::size_t k = 1; k < tries_.size(); ++k) {
      Try& other = *tries_[k];
      if (!other.failure.empty()) {
        restarts_.push_back({{"failure", other.failure}});
        continue;
      }
      restarts_.push_back({{"end", values(other.found.u)}, {"cost", other.found.cost}});
      if (is_better(other.found)) use(other);
    }
  }

  /// Of a likelihood: on samples that both accept.
  bool is_better(const Found& other) {
    if (plan_.objective != Objective::likelihood) return other.cost < found_.cost;
    const Json both =
        compared(judged(plan_.over, found_.u, plan_.until, false), judged(plan_.over, other.u, plan_.until, false));
    const double gain = both.at("likelihood").at("end").get<double>() - both.at("likelihood").at("start").get<double>();
    return gain - prior_cost(plan_, other.u, nullptr) + prior_cost(plan_, found_.u, nullptr) > 0;
  }

  std::vector<Judgement> judged(const std::vector<Member>& members, const std::vector<double>& u,
                                const std::optional<When>& until, bool is_after) {
    std::vector<Judgement> all(members.size());
    in_parallel(options_.jobs, all.size(), [&](std::size_t m) {
      all[m] = judge(members[m], sets_of(plan_.parameters, u, runs_->config(0)), until, is_after, options_);
    });
    return all;
  }

  Json values(const std::vector<double>& u) const {
    Json json = Json::object();
    for (std::size_t p = 0; p < u.size(); ++p)
      json[plan_.parameters[p].place.name()] =
          shown_value(plan_.parameters[p].place, plan_.parameters[p].value_of(u[p]));
    return json;
  }

  /// What is at a bound, or in a direction that the curvature leaves open, is not free any more. False where nothing is.
  bool hold_what_is_open() {
    bool is_any = false;
    for (const std::size_t p : found_.free) {
      const Parameter& parameter = plan_.parameters[p];
      const double u = found_.u[p];
      const bool is_at_bound = std::min(u - parameter.lower, parameter.upper - u) < 1e-3;
      if (!is_at_bound) continue;
      is_any = true;
      states_[p] = parameter.has_bounds ? State::at_bound : State::undetermined;
      if (!parameter.has_bounds) note_open({p}, {1.0}, std::numeric_limits<double>::infinity());
    }
    if (is_any) return true;
    std::vector<double> u;
    for (const std::size_t p : found_.free) u.push_back(found_.u[p]);
    curvature_ = curvature(found_.function, u, found_.curvature_step);
    const bool is_in_nats = plan_.objective == Objective::likelihood || plan_.objective == Objective::withheld_nll;
    const auto open = open_directions(curvature_, is_in_nats ? undetermined_sigma : 1e6);
    for (const OpenDirection& direction : open) {
      std::vector<std::size_t> involved;
      std::vector<double> shares;
      for (const std::size_t i : direction.involved) {
        involved.push_back(found_.free[i]);
        shares.push_back(direction.direction[static_cast<Eigen::Index>(i)]);
      }
      note_open(involved, shares, direction.sigma);
    }
    for (const OpenDirection& direction : open)
      for (const std::size_t i : direction.involved) states_[found_.free[i]] = State::undetermined;
    return !open.empty();
  }

  void note_open(const std::vector<std::size_t>& involved, const std::vector<double>& shares, double sigma) {
    Json direction = Json::object();
    std::vector<std::string> names;
    for (std::size_t i = 0; i < involved.size(); ++i) {
      const std::string name = plan_.parameters[involved[i]].place.name();
      direction[name] = shares[i];
      names.push_back(name);
    }
    std::string text = listed(names);
    if (involved.size() > 1) text += ": together, in this direction,";
    text += sigma < 5 ? " known no better than by a factor of " + wording::short_number(std::exp(sigma))
                      : ": the objective does not depend on it there, or still improves at the end of the range";
    Json entry = {{"direction", direction}, {"sigma", std::isfinite(sigma) ? Json(sigma) : Json()}, {"text", text}};
    if (involved.size() == 1) note_limit(involved.front(), entry);
    undetermined_.push_back(std::move(entry));
  }

  /// Where the start itself is ruled out: the value at which ln p is 2 less than at the end, on the way to it.
  void note_limit(std::size_t p, Json& entry) {
    if (plan_.objective != Objective::likelihood || !found_.linearized) return;
    const double best = loss(p, found_.u[p]);
    double inside = found_.u[p], outside = start_[p];
    if (!(loss(p, outside) - best > 2)) return;
    for (int k = 0; k < 30; ++k) {
      const double middle = 0.5 * (inside + outside);
      (loss(p, middle) - best > 2 ? outside : inside) = middle;
    }
    const Parameter& parameter = plan_.parameters[p];
    const char* const side = found_.u[p] < start_[p] ? "below " : "above ";
    const Json limit = shown_value(parameter.place, rounded(parameter.value_of(outside)));
    entry["limit"] = {{"side", side}, {"value", limit}};
    entry["text"] = entry.at("text").get<std::string>() + "; the data only show that it is " + side +
                    (limit.is_string() ? limit.get<std::string>() : limit.dump()) +
                    "; the value of the config is not: set it yourself";
  }

  /// The objective with one parameter at u.
  double loss(std::size_t p, double u) const {
    std::vector<double> at;
    for (const std::size_t i : found_.free) at.push_back(i == p ? u : found_.u[i]);
    return found_.function.value(at, nullptr);
  }

  Json parameters() const {
    Json list = Json::array();
    Eigen::MatrixXd covariance;
    const bool is_in_nats = plan_.objective == Objective::likelihood || plan_.objective == Objective::withheld_nll;
    if (!found_.free.empty() && is_in_nats) covariance = algebra::inverse(curvature_);
    for (std::size_t p = 0; p < plan_.parameters.size(); ++p) {
      const Parameter& parameter = plan_.parameters[p];
      const Place& place = parameter.place;
      Json entry = {{"name", place.name()},
                    {"start", shown_value(place, place.value)},
                    {"state", state_word(states_[p])},
                    {"noise", is_of_noise(laws_[p])}};
      const bool is_returned = states_[p] == State::determined || states_[p] == State::at_bound;
      if (is_returned) entry["end"] = shown_value(place, parameter.value_of(found_.u[p]));
      const auto free = std::ranges::find(found_.free, p);
      if (is_returned && free != found_.free.end()) {
        const auto i = free - found_.free.begin();
        const double here = found_.function.value(picked(), nullptr), there = loss(p, start_[p]);
        entry["evidence"] = std::isfinite(there) ? Json(there - here) : Json();
        if (covariance.size() > 0) note_error(entry, parameter, found_.u[p], std::sqrt(covariance(i, i)));
      }
      list.push_back(std::move(entry));
    }
    return list;
  }

  std::vector<double> picked() const {
    std::vector<double> u;
    for (const std::size_t p : found_.free) u.push_back(found_.u[p]);
    return u;
  }

  static void note_error(Json& entry, const Parameter& parameter, double u, double sigma) {
    entry["standard_error"] = sigma * (parameter.is_log ? 1 : parameter.step);
    entry["relative"] = parameter.is_log;
    entry["interval"] = {shown_value(parameter.place, parameter.value_of(u - 2 * sigma)),
                         shown_value(parameter.place, parameter.value_of(u + 2 * sigma))};
  }

  /// The filter as configured finds the rows that both ends accept less likely at the end, by more than evidence of 2: the
  /// search went along a path, or by gates, that the filter does not take. A prior may want that. A start that accepts a fifth
  /// fewer rows keeps those that suit it, which says nothing of the others.
  bool is_lowered(const Json& used) const {
    const bool has_prior =
        std::ranges::any_of(plan_.parameters, [](const Parameter& p) { return p.prior.has_value(); });
    if (plan_.objective != Objective::likelihood || has_prior || used.contains("failure")) return false;
    const auto figure = [&](const char* name) { return used.at("likelihood").at(name).get<double>(); };
    return figure("end") < figure("start") - 2 && figure("rows_start") > 0.8 * figure("rows_end");
  }

  /// Both ends on the parts that were not used; where there is none, on what was.
  Json judged_parts() {
    Json parts = Json::object();
    const auto compare = [&](const std::vector<Member>& members, const std::optional<When>& until,
                             bool is_after) -> Json {
      try {
        return compared(judged(members, start_, until, is_after), judged(members, found_.u, until, is_after));
      } catch (const FilterError& error) {
        return {{"failure", error.diagnostics().items().front().message}};
      }
    };
    parts["used"] = compare(plan_.over, plan_.until, false);
    if (plan_.until) parts["unseen"]["after 'until'"] = compare(plan_.over, plan_.until, true);
    for (const Member& member : plan_.unseen)
      parts["unseen"][member.config.filename().string()] = compare({member}, std::nullopt, false);
    return parts;
  }

  Json notes() const {
    Json notes = Json::array();
    if (!search_->fallback().empty())
      notes.push_back("the gradient is computed by differences: " + search_->fallback());
    if (!found_.free.empty() && !found_.is_converged)
      notes.push_back("not converged: the last round still gained, or accepted other samples");
    if (!found_.rounds.empty() && found_.rounds.back().value("gates", "") == "off")
      notes.push_back("gates are off: with them on, a tenth or more of the samples is refused");
    if (!found_.rounds.empty() && found_.rounds.back().value("gates", "") == "frozen")
      notes.push_back(
          "the set of accepted samples did not converge (the tails are heavier than those of a Gaussian): it was "
          "frozen where the gates refused least");
    if (plan_.unseen.empty() && !plan_.until)
      notes.push_back("no data are left for a check: use 'until' or 'unseen' of 'tune'");
    if (!runs_->not_ekf().empty())
      notes.push_back("the update of " + listed(runs_->not_ekf()) +
                      " depends on P and R: in a round H is held, so its gradient is approximate");
    if (!runs_->unscented().empty())
      notes.push_back(
          "the propagation of " + listed(runs_->unscented()) +
          " by sigma points depends on P: in a round the transition is held, so its gradient is approximate");
    if (runs_->missed() > 0)
      notes.push_back(std::to_string(runs_->missed()) +
                      " samples have no slope: their outcome changes with a small change of a parameter");
    return notes;
  }

  Json report() {
    static const char* const objectives[] = {"likelihood", "withheld nll", "withheld rms", "metric"};
    std::vector<bool> is_returned;
    for (const State state : states_) is_returned.push_back(state == State::determined || state == State::at_bound);
    Json result = {{"objective", plan_.objective == Objective::metric ? plan_.metric
                                                                      : objectives[static_cast<int>(plan_.objective)]},
                   {"parameters", parameters()},
                   {"undetermined", undetermined_}};
    if (!found_.rounds.empty()) {
      result["value"] = {{"end", -found_.cost}};
      if (found_.linearized) {
        search_->check_gradient(*found_.linearized, found_.u);
        result["gradient_error"] = search_->gradient_error();
        const double start = loss_at(start_);
        result["value"] = {{"start", std::isfinite(start) ? Json(-start) : Json()}, {"end", -loss_at(found_.u)}};
      } else if (plan_.objective != Objective::likelihood) {
        result["value"] = {{"start", found_.rounds.front().at("start")}, {"end", found_.cost}};
      }
    }
    result["converged"] = found_.is_converged;
    result["rounds"] = found_.rounds;
    if (!restarts_.empty()) result["restarts"] = restarts_;
    int evaluations = 0, made = first_runs_.made();
    for (const auto& one : tries_) {
      evaluations += one->search.evaluations();
      made += one->runs.made() - first_runs_.made();
    }
    result["evaluations"] = evaluations;
    result["judged"] = judged_parts();
    result["lowered"] = is_lowered(result.at("judged").at("used"));
    result["runs"] = made;
    auto end = found_.u;
    for (std::size_t p = 0; p < end.size(); ++p)
      end[p] = plan_.parameters[p].u_of(rounded(plan_.parameters[p].value_of(end[p])));
    result["patch"] = patch_of(plan_.parameters, end, is_returned, runs_->config(0));
    result["notes"] = notes();
    return result;
  }

  double loss_at(const std::vector<double>& u) const {
    std::vector<double> at;
    for (const std::size_t p : found_.free) at.push_back(u[p]);
    return found_.function.value(at, nullptr);
  }

  const Plan& plan_;
  const TuneOptions& options_;
  Runs first_runs_;  // what every start begins with
  Runs* runs_;       // of the best
  std::vector<State> states_;
  std::vector<double> start_;
  std::vector<Law> laws_;
  std::vector<std::unique_ptr<Try>> tries_;
  Search* search_ = nullptr;  // of the best
  Found found_;
  Eigen::MatrixXd curvature_;
  Json undetermined_ = Json::array(), restarts_ = Json::array();
};

}  // namespace

Json tune(const Plan& plan, const TuneOptions& options) { return Tuner(plan, options).tune(); }

}  // namespace binnacle::tune
