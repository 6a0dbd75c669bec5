// SPDX-License-Identifier: Apache-2.0
#include "runs.hpp"

#include <algorithm>
#include <utility>

#include "binnacle/run.hpp"
#include "score/sections.hpp"
#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;

namespace {

constexpr double nudge = 1e-4;  // by which a parameter is changed for a slope: Δu

class Attach final : public RunObserver {
 public:
  Attach(const std::vector<StepObserver*>& observers, const std::function<bool()>& goes_on)
      : observers_(observers), goes_on_(goes_on) {}
  void begin(Session& session) override {
    for (std::size_t f = 0; f < observers_.size(); ++f) session.attach({static_cast<int>(f)}, observers_[f]);
  }
  bool progress(Time) override { return is_going = goes_on_(); }
  bool is_going = true;

 private:
  const std::vector<StepObserver*>& observers_;
  const std::function<bool()>& goes_on_;
};

/// R that is learnt from the innovations has no likelihood of its own to be tuned by.
void refuse_adaptive(const Composition& composition, const Member& member) {
  Diagnostics diagnostics;
  const Config config = score::load_config(member.config, member.load);
  for (const FilterInfo& filter : composition.filters())
    for (const MeasurementInfo& measurement : filter.measurements) {
      if (!measurement.noise.object) continue;
      const std::string pointer = "/filters/" + filter.name + "/measurements/" + measurement.name + "/noise";
      diagnostics.error("B130", config.key_origin(pointer), pointer,
                        "R of " + in_quotes(measurement.name) + " is made of its innovations by " +
                            in_quotes(measurement.noise.name) +
                            ", so it follows every tuned parameter; to tune without it: --set " + pointer + "=null");
    }
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
}

}  // namespace

void observed_run(const std::shared_ptr<const Composition>& composition, const std::vector<StepObserver*>& observers,
                  const RunSettings& settings) {
  Attach attach(observers, settings.goes_on);
  RunOptions options;
  options.seed = settings.seed;
  options.run = settings.run;
  options.observer = &attach;
  options.feeds_sinks = false;
  const RunResult result = binnacle::run(composition, options);
  if (!attach.is_going) throw Interrupted();
  if (!result.failures.empty()) throw FilterError(result.failures);
}

namespace {

/// (filter, measurement) by their keys, of a config.
std::vector<std::pair<std::string, std::string>> measurements_of(const Json& config) {
  std::vector<std::pair<std::string, std::string>> names;
  for (const auto& [filter, of_filter] : config.at("filters").items())
    if (of_filter.contains("measurements"))
      for (const auto& [name, ignored] : of_filter.at("measurements").items()) names.emplace_back(filter, name);
  return names;
}

std::string pointer_of(const std::pair<std::string, std::string>& measurement) {
  return join_pointer(join_pointer("/filters", measurement.first) + "/measurements", measurement.second);
}

/// Withholds all, and takes Jacobians: sigma points would make Φ, H and R depend on Q.
std::vector<std::string> all_withheld(const Json& config) {
  std::vector<std::string> sets;
  for (const auto& [name, filter] : config.at("filters").items())
    for (auto& set : score::by_jacobians(config, name)) sets.push_back(std::move(set));
  for (const auto& measurement : measurements_of(config))
    sets.push_back(pointer_of(measurement) + "/withhold={\"every\": 1}");
  return sets;
}

}  // namespace

double law_value(Law law, double value) { return law == Law::linear ? value : value * value; }

double law_slope(Law law, const Parameter& parameter, double value) {
  const double by_value = law == Law::linear ? 1 : 2 * value;
  return by_value * (parameter.is_log ? value : parameter.step);
}

Runs::Runs(const Plan& plan, RunSettings settings) : plan_(plan), settings_(std::move(settings)) {
  for (const Member& member : plan.over) {
    configs_.push_back(Json::parse(score::load_config(member.config, member.load).text()));
    if (plan.objective != Objective::likelihood) continue;
    const auto composition = score::load(member.config, member.load);
    refuse_adaptive(*composition, member);
    for (const FilterInfo& filter : composition->filters()) {
      if (filter.is_unscented) unscented_.insert(in_quotes(filter.name));
      for (const MeasurementInfo& measurement : filter.measurements)
        if (measurement.update.type != "ekf") not_ekf_.insert(in_quotes(measurement.name));
    }
  }
  frozen_.resize(plan.over.size());
}

std::vector<std::string> Runs::gate_sets(std::size_t member, Gates gates) const {
  std::vector<std::string> sets;
  if (gates == Gates::as_configured) return sets;
  for (const auto& measurement : measurements_of(configs_[member])) {
    const std::string at = pointer_of(measurement);
    for (const char* key : {"/gate", "/recover"})
      if (configs_[member].contains(Json::json_pointer(at + key))) sets.push_back(at + key + "=null");
  }
  if (gates == Gates::frozen) sets.insert(sets.end(), frozen_[member].begin(), frozen_[member].end());
  return sets;
}

std::shared_ptr<const Composition> Runs::compose(std::size_t member, const std::vector<double>& u, Gates gates,
                                                 const std::vector<std::string>& more) const {
  LoadOptions load = plan_.over[member].load;
  for (const auto& sets : {sets_of(plan_.parameters, u, configs_[member]), gate_sets(member, gates), more})
    load.sets.insert(load.sets.end(), sets.begin(), sets.end());
  return score::load(plan_.over[member].config, load);
}

std::vector<Law> Runs::laws() {
  struct Task {
    std::size_t member;
    std::vector<double> u;
    std::vector<std::unique_ptr<Response>> responses;  // by filter; none where it cannot be run
  };
  const std::size_t count = plan_.parameters.size(), members = plan_.over.size();
  std::vector<double> start;
  for (const Parameter& parameter : plan_.parameters) start.push_back(parameter.u_of(parameter.place.value));
  std::vector<Task> tasks;
  for (std::size_t m = 0; m < members; ++m) {
    tasks.push_back({m, start, {}});
    for (std::size_t p = 0; p < count; ++p)
      for (const double factor : {2.0, 4.0}) {
        const Parameter& parameter = plan_.parameters[p];
        auto u = start;
        // What starts at 0 is no noise: any step shows that.
        const double value = parameter.place.value;
        u[p] = value != 0 ? parameter.u_of(factor * value) : factor;
        tasks.push_back({m, std::move(u), {}});
      }
  }
  in_parallel(settings_.jobs, tasks.size(), [&](std::size_t t) {
    const std::vector<std::string> withhold = all_withheld(configs_[tasks[t].member]);
    std::vector<std::unique_ptr<Response>> responses;
    try {
      const auto composition = compose(tasks[t].member, tasks[t].u, Gates::off, withhold);
      std::vector<StepObserver*> observers;
      for (const FilterInfo& filter : composition->filters())
        observers.push_back(responses.emplace_back(std::make_unique<Response>(filter)).get());
      observed_run(composition, observers, settings_);
    } catch (const Error&) {
      // Out of the parameter's range, or broken without a fix: what was seen until then counts, where there is any.
    }
    tasks[t].responses = std::move(responses);
  });
  made_ += static_cast<int>(tasks.size());
  std::vector<Law> laws;
  for (std::size_t p = 0; p < count; ++p) {
    std::vector<const Response*> seen[3];
    bool is_whole = true;
    for (std::size_t m = 0; m < members; ++m) {
      const Task* const of_member = &tasks[m * (1 + 2 * count)];
      const Task* const three[] = {of_member, of_member + 1 + 2 * p, of_member + 2 + 2 * p};
      for (int k = 0; k < 3; ++k) {
        is_whole = is_whole && three[k]->responses.size() == three[0]->responses.size() && !three[k]->responses.empty();
        for (const auto& response : three[k]->responses) seen[k].push_back(response.get());
      }
    }
    laws.push_back(is_whole ? law_of(seen[0], seen[1], seen[2]) : Law::other);
    acts_on_R_.push_back(is_of_noise(laws.back()) && differ_in_R(seen[0], seen[1]));
  }
  return laws;
}

std::vector<MemberRun> Runs::record(const std::vector<double>& u, Gates gates) {
  std::vector<MemberRun> runs(plan_.over.size());
  in_parallel(settings_.jobs, runs.size(), [&](std::size_t m) {
    runs[m].composition = compose(m, u, gates);
    std::vector<std::unique_ptr<LogRecorder>> recorders;
    std::vector<StepObserver*> observers;
    for (const FilterInfo& filter : runs[m].composition->filters()) {
      RecordedRun& recorded = *runs[m].filters.emplace_back(std::make_unique<RecordedRun>(filter));
      recorders.push_back(std::make_unique<LogRecorder>(filter, recorded, Until(plan_.until)));
      observers.push_back(recorders.back().get());
    }
    observed_run(runs[m].composition, observers, settings_);
  });
  made_ += static_cast<int>(runs.size());
  return runs;
}

std::vector<std::vector<SparseTerm>> Runs::slopes(std::size_t member, const MemberRun& run, double change,
                                                  const std::vector<double>& u, Gates gates, int& missed) const {
  const auto composition = compose(member, u, gates);
  std::vector<std::unique_ptr<SlopeRecorder>> recorders;
  std::vector<StepObserver*> observers;
  for (std::size_t f = 0; f < run.filters.size(); ++f) {
    const int dof = composition->filters()[f].dof;
    recorders.push_back(std::make_unique<SlopeRecorder>(*run.filters[f], dof, change, Until(plan_.until)));
    observers.push_back(recorders.back().get());
  }
  observed_run(composition, observers, settings_);
  std::vector<std::vector<SparseTerm>> terms;
  missed = 0;
  for (std::size_t f = 0; f < run.filters.size(); ++f) {
    missed += recorders[f]->is_alike() ? recorders[f]->missed() : static_cast<int>(run.filters[f]->accepted.size());
    terms.push_back(std::move(recorders[f]->terms()));
  }
  return terms;
}

void Runs::add_slopes(std::vector<MemberRun>& runs, const std::vector<double>& u, const std::vector<Law>& laws,
                      Gates gates) {
  struct Task {
    std::size_t parameter, member;
    std::vector<std::vector<SparseTerm>> terms;  // by filter
    int missed = 0, tries = 0;
  };
  std::vector<Task> tasks;
  for (std::size_t p = 0; p < laws.size(); ++p)
    for (std::size_t m = 0; m < runs.size() && is_of_noise(laws[p]); ++m) tasks.push_back({p, m, {}});
  in_parallel(settings_.jobs, tasks.size(), [&](std::size_t t) {
    Task& task = tasks[t];
    const Parameter& parameter = plan_.parameters[task.parameter];
    // A sample that is judged otherwise has no slope; most likely the other direction judges it alike.
    for (const double by : {nudge, -nudge, 0.01 * nudge}) {
      auto changed = u;
      changed[task.parameter] += by;
      const Law law = laws[task.parameter];
      const double change = law_value(law, parameter.value_of(changed[task.parameter])) -
                            law_value(law, parameter.value_of(u[task.parameter]));
      task.terms = slopes(task.member, runs[task.member], change, changed, gates, task.missed);
      ++task.tries;
      if (task.missed == 0) return;
    }
  });
  for (Task& task : tasks) {
    made_ += task.tries;
    missed_ += task.missed;
    for (std::size_t f = 0; f < task.terms.size(); ++f) {
      LinearLog& log = runs[task.member].filters[f]->log;
      log.begin_parameter();
      for (std::size_t e = 0; e < task.terms[f].size(); ++e) log.add_term(e, std::move(task.terms[f][e]));
    }
  }
}

void Runs::freeze(const std::vector<MemberRun>& runs) {
  for (std::size_t m = 0; m < runs.size(); ++m) {
    frozen_[m].clear();
    const auto& filters = runs[m].composition->filters();
    for (std::size_t f = 0; f < filters.size(); ++f)
      for (std::size_t k = 0; k < filters[f].measurements.size(); ++k) {
        const std::string at =
            join_pointer(join_pointer("/filters", filters[f].name) + "/measurements", filters[f].measurements[k].name) +
            "/withhold";
        const Json::json_pointer own(at);
        Json withhold = configs_[m].contains(own) ? configs_[m].at(own) : Json::array();
        if (withhold.is_array()) withhold = {{"windows", withhold}};
        Json& windows = withhold["windows"];
        const std::size_t before = windows.size();
        for (const RefusedSample& sample : runs[m].filters[f]->refused)
          if (sample.measurement == static_cast<int>(k))
            windows.push_back({std::to_string(sample.t - 1) + " ns", std::to_string(sample.t + 1) + " ns"});
        if (windows.size() > before) frozen_[m].push_back(at + "=" + withhold.dump());
      }
  }
}

Counts Runs::count(const std::vector<MemberRun>& runs) const {
  Counts all;
  for (const MemberRun& run : runs)
    for (const auto& filter : run.filters) {
      all.samples += static_cast<int>(filter->accepted.size());
      all.rows += filter->rows;
      all.refused += static_cast<int>(filter->refused.size());
      all.rows_refused += filter->rows_refused;
      all.recoveries += filter->recoveries;
      all.nis += filter->nis;
      all.likelihood += filter->log.likelihood(std::vector<double>(as_size(filter->log.parameters())));
    }
  return all;
}

}  // namespace binnacle::tune
