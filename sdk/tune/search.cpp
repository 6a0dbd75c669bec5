// SPDX-License-Identifier: Apache-2.0
#include "search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

#include "score/run.hpp"
#include "score/sections.hpp"
#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;

namespace {

constexpr int most_rounds = 12, most_evaluations = 300;
constexpr double settled = 0.01;        // gain of a round in ln p: a seventh of a sigma
constexpr double tolerance = 1e-3;      // of ln p, within a round
constexpr double largest_share = 0.1;   // refused, beyond which gates are left out of a round
constexpr double largest_error = 1e-4;  // of the sweep's gradient
constexpr int most_scorings = 12;
constexpr double least_information = 1e-8;  // in ln g: what is less has no direction
constexpr double deepest_cut = 0.01;        // of g, in a step of scoring
constexpr double least_weight = 0.3;        // of a parameter that says little
constexpr double curved_reach = 0.7;        // by which a round may change what noise is not affine in: a factor of 2

std::vector<double> picked(const std::vector<double>& all, const std::vector<std::size_t>& free) {
  std::vector<double> values;
  for (const std::size_t p : free) values.push_back(all[p]);
  return values;
}

Json shown(const Counts& counts) {
  return {{"samples", counts.samples},
          {"rows", counts.rows},
          {"refused", counts.refused},
          {"rows_left_out", counts.rows_left_out},
          {"recoveries", counts.recoveries}};
}

bool are_equal(const Counts& a, const Counts& b) { return a.samples == b.samples && a.rows == b.rows; }

}  // namespace

std::vector<double> expanded(const std::vector<double>& u, const std::vector<std::size_t>& free,
                             const std::vector<double>& values) {
  auto all = u;
  for (std::size_t i = 0; i < free.size(); ++i) all[free[i]] = values[i];
  return all;
}

Search::Search(const Plan& plan, const TuneOptions& options, Runs& runs, std::vector<Law> laws)
    : plan_(plan), options_(options), runs_(runs), laws_(std::move(laws)) {}

/// As configured, unless its gates refuse much of what comes: then they say more of the start than of the data.
Search::Round Search::record(const std::vector<double>& u) {
  Round round;
  bool is_broken = false;
  try {
    round.runs = runs_.record(u, Gates::as_configured);
    round.counts = runs_.count(round.runs);
  } catch (const FilterError&) {
    is_broken = true;
  }
  const Counts& counts = round.counts;
  if (is_broken || counts.refused > largest_share * (counts.samples + counts.refused)) {
    round.gates = Gates::off;
    round.runs = runs_.record(u, Gates::off);
    round.counts = runs_.count(round.runs);
  }
  return round;
}

void Search::set_bounds(Function& function, const Found& found) const {
  for (const std::size_t p : found.free) {
    const Parameter& parameter = plan_.parameters[p];
    const bool is_curved = laws_[p] == Law::curved;
    const double reach = is_curved ? curved_reach * (parameter.is_log ? 1 : std::abs(found.u[p])) : 0;
    function.lower.push_back(is_curved ? std::max(parameter.lower, found.u[p] - reach) : parameter.lower);
    function.upper.push_back(is_curved ? std::min(parameter.upper, found.u[p] + reach) : parameter.upper);
  }
}

Function Search::linearized(Found& found, Round round) {
  std::vector<Law> laws(laws_.size(), Law::none);
  for (const std::size_t p : found.free) laws[p] = laws_[p];
  runs_.add_slopes(round.runs, found.u, laws, round.gates);
  const auto log = std::make_shared<const Linearized>(plan_, std::move(round.runs), found.u, laws, options_.jobs);
  found.linearized = log;
  const double error = tune::gradient_error(*log, found.u);
  gradient_error_ = std::max(gradient_error_, error);
  if (error > largest_error)
    fallback_ = log->has_considered()
                    ? "with considered components gains are not optimal, and the sweep's gradient is not exact"
                    : "the sweep's gradient differs from differences of the likelihood";
  Function function;
  function.tolerance = tolerance;
  const bool by_differences = !fallback_.empty();
  function.value = [this, log, u = found.u, free = found.free, by_differences](const std::vector<double>& values,
                                                                               double* gradient) {
    if (!options_.goes_on()) throw Interrupted();
    const auto at = expanded(u, free, values);
    std::vector<double> slopes(at.size());
    const double likelihood = log->likelihood(at, gradient && !by_differences ? slopes.data() : nullptr);
    if (gradient && by_differences) log->differences(at, slopes.data());
    for (double& slope : slopes) slope = -slope;
    const double prior = prior_cost(plan_, at, slopes.data());
    for (std::size_t i = 0; i < free.size() && gradient; ++i) gradient[i] = slopes[free[i]];
    return prior - likelihood;
  };
  return function;
}

/// Fisher's scoring by g, in which the likelihood of a variance is nearly a parabola from above and from below: from a start
/// that is decades off it arrives in a few steps, where in ln g what is far too small has no slope.
std::vector<double> Search::approach(Found& found, const Linearized& log, Function& function) {
  auto u = found.u;
  const auto noise = log.noise();
  Eigen::VectorXd gradient;
  Eigen::MatrixXd information;
  double value = log.information(u, gradient, information);
  ++evaluations_;
  for (int k = 0; k < most_scorings && std::isfinite(value); ++k) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(information);
    Eigen::VectorXd along = solver.eigenvectors().transpose() * gradient;
    for (Eigen::Index i = 0; i < along.size(); ++i)
      along[i] = solver.eigenvalues()[i] > least_information ? along[i] / solver.eigenvalues()[i] : 0;
    const Eigen::VectorXd step = solver.eigenvectors() * along;
    if (!(gradient.dot(step) > 2 * settled)) break;
    auto next = u;
    for (std::size_t i = 0; i < noise.size(); ++i) {
      const std::size_t p = noise[i];
      const double g = law_value(laws_[p], plan_.parameters[p].value_of(u[p])) *
                       std::max(1 + step[static_cast<Eigen::Index>(i)], deepest_cut);
      next[p] = std::clamp(plan_.parameters[p].u_of(laws_[p] == Law::linear ? g : std::sqrt(g)), function.lower[i],
                           function.upper[i]);
    }
    const double before = value;
    for (int halving = 0; halving < 4; ++halving) {
      value = log.information(next, gradient, information);
      ++evaluations_;
      if (value > before) break;
      for (std::size_t p = 0; p < u.size(); ++p) next[p] = 0.5 * (u[p] + next[p]);
    }
    if (!(value > before)) break;
    u = next;
    if (value - before < settled) break;
  }
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const Parameter& parameter = plan_.parameters[noise[i]];
    const double at = parameter.value_of(u[noise[i]]);
    const double by_u = law_slope(laws_[noise[i]], parameter, at) / law_value(laws_[noise[i]], at);
    const auto k = static_cast<Eigen::Index>(i);
    const bool is_known = information.rows() > k && std::isfinite(information(k, k));
    function.weights.push_back(is_known ? std::max(least_weight, by_u * std::sqrt(std::max(0.0, information(k, k))))
                                        : 1);
  }
  return u;
}

Function Search::by_runs(const Found& found) {
  Function function;
  function.tolerance = tolerance;
  function.value = [this, u = found.u, free = found.free](const std::vector<double>& values, double* gradient) {
    constexpr double step = 1e-3;
    const auto at = expanded(u, free, values);
    const auto likelihood_at = [&](const std::vector<double>& place) {
      try {
        const std::vector<Law> no_slopes(laws_.size(), Law::none);
        return Linearized(plan_, runs_.record(place, Gates::frozen), place, no_slopes, options_.jobs)
            .likelihood(place, nullptr);
      } catch (const Error&) {
        return -std::numeric_limits<double>::infinity();  // the filter breaks there, or the value is out of its range
      }
    };
    std::vector<double> slopes(at.size());
    double likelihood = 0;
    if (!gradient) {
      likelihood = likelihood_at(at);
    } else {
      try {
        std::vector<Law> laws(laws_.size(), Law::none);
        for (const std::size_t p : free) laws[p] = laws_[p];
        auto runs = runs_.record(at, Gates::frozen);
        runs_.add_slopes(runs, at, laws, Gates::frozen);
        likelihood = Linearized(plan_, std::move(runs), at, laws, options_.jobs).likelihood(at, slopes.data());
      } catch (const Error&) {
        return std::numeric_limits<double>::infinity();
      }
      for (const std::size_t p : free) {
        if (is_of_noise(laws_[p])) continue;
        auto above = at, below = at;
        above[p] += step, below[p] -= step;
        slopes[p] = (likelihood_at(above) - likelihood_at(below)) / (2 * step);
      }
    }
    for (double& slope : slopes) slope = -slope;
    const double prior = prior_cost(plan_, at, slopes.data());
    for (std::size_t i = 0; i < free.size() && gradient; ++i) gradient[i] = slopes[free[i]];
    return prior - likelihood;
  };
  return function;
}

double Search::judged(const std::vector<double>& u) const {
  std::vector<Judgement> all(plan_.over.size());
  std::vector<double> values(plan_.over.size());
  in_parallel(options_.jobs, all.size(), [&](std::size_t m) {
    const Member& member = plan_.over[m];
    const auto sets = sets_of(plan_.parameters, u, runs_.config(m));
    if (plan_.objective != Objective::metric) {
      all[m] = judge(member, sets, plan_.until, false, options_);
      return;
    }
    LoadOptions load = member.load;
    load.sets.insert(load.sets.end(), sets.begin(), sets.end());
    const auto composition = score::load(member.config, load);
    const auto metric = score::read_metric(*composition, plan_.metric);
    if (!metric)
      throw ConfigError(
          {Severity::error, "B027", {member.config.string(), 0, 0}, "/tune/objective/metric", metric.error()});
    score::RunOptions run;
    run.seed = options_.seed;
    run.run = options_.run;
    run.metrics = {*metric};
    run.feeds_sinks = false;
    const auto result = score::run(composition, run);
    if (!result.failures.empty()) throw FilterError(result.failures);
    values[m] = result.metrics.front().value;
  });
  if (plan_.objective == Objective::withheld_nll) return withheld_nll(all);
  if (plan_.objective == Objective::withheld_rms) return withheld_rms(all);
  double sum = 0;
  for (const double value : values) sum += std::abs(value);
  return sum / static_cast<double>(values.size());
}

Function Search::by_judgement(const Found& found) {
  Function function;
  function.has_gradient = false;
  function.value = [this, u = found.u, free = found.free](const std::vector<double>& values, double*) {
    if (!options_.goes_on()) throw Interrupted();
    const auto at = expanded(u, free, values);
    double value = std::nan("");
    try {
      value = judged(at);
    } catch (const FilterError&) {
      return std::numeric_limits<double>::infinity();
    }
    if (std::isnan(value))
      throw ConfigError({Severity::error,
                         "B131",
                         {},
                         "/tune/objective",
                         "there is nothing to make the objective of: no sample was withheld, or nothing was scored"});
    return value + (plan_.objective == Objective::metric ? 0 : prior_cost(plan_, at, nullptr));
  };
  return function;
}

Function Search::function_of(Found& found, Round round, std::vector<double>& start) {
  const bool is_of_noise_alone = std::ranges::all_of(found.free, [&](std::size_t p) { return is_of_noise(laws_[p]); });
  Function function;
  if (is_of_noise_alone) {
    function = linearized(found, std::move(round));
    found.curvature_step = 1e-3;
  } else {
    runs_.freeze(round.runs);
    function = by_runs(found);
    found.curvature_step = 1e-2;
  }
  set_bounds(function, found);
  start = is_of_noise_alone ? approach(found, *found.linearized, function) : found.u;
  return function;
}

Found Search::from(std::vector<double> u, const std::vector<bool>& is_free) {
  Found found;
  found.u = std::move(u);
  for (std::size_t p = 0; p < is_free.size(); ++p)
    if (is_free[p]) found.free.push_back(p);
  if (plan_.objective != Objective::likelihood) {
    found.function = by_judgement(found);
    found.function.tolerance = plan_.objective == Objective::metric ? 0 : tolerance;
    found.curvature_step = 0.1;
    set_bounds(found.function, found);
    const Minimum minimum = minimize(found.function, picked(found.u, found.free), most_evaluations);
    evaluations_ += minimum.evaluations;
    found.u = expanded(found.u, found.free, minimum.u);
    found.cost = minimum.value;
    found.is_converged = minimum.is_converged;
    found.rounds.push_back({{"evaluations", minimum.evaluations}, {"start", minimum.first}, {"end", minimum.value}});
    return found;
  }
  Counts last;
  for (int round = 0; round < most_rounds && !found.is_converged; ++round) {
    Round recorded = record(found.u);
    const Counts counts = recorded.counts;
    const Gates gates = recorded.gates;
    if (counts.rows == 0)
      throw FilterError({Severity::error, "B131", {}, "/tune", "no sample was accepted, so there is no likelihood"});
    const int before = evaluations_;
    std::vector<double> start;
    found.function = function_of(found, std::move(recorded), start);
    const double cost = found.function.value(picked(found.u, found.free), nullptr);
    Minimum minimum = minimize(found.function, picked(start, found.free), most_evaluations);
    evaluations_ += minimum.evaluations;
    minimum.first = cost;
    found.u = expanded(found.u, found.free, minimum.u);
    found.cost = minimum.value;
    Json entry = {{"evaluations", evaluations_ - before},
                  {"start", minimum.first},
                  {"end", minimum.value},
                  {"gates", gates == Gates::off ? "off" : "as configured"}};
    entry.update(shown(counts));
    found.rounds.push_back(entry);
    options_.on_round("round " + std::to_string(round + 1) + ": " + std::to_string(evaluations_ - before) + " (" +
                      std::to_string(minimum.evaluations) + ")" + " evaluations, " + std::to_string(counts.rows) +
                      " rows, gain " + std::to_string(minimum.first - minimum.value));
    found.is_converged = round > 0 && minimum.first - minimum.value < settled && are_equal(counts, last);
    last = counts;
  }
  return found;
}

}  // namespace binnacle::tune
