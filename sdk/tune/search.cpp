// SPDX-License-Identifier: Apache-2.0
#include "search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>

#include "algebra/decompositions.hpp"
#include "binnacle/eigen.hpp"
#include "score/run.hpp"
#include "score/sections.hpp"
#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;

namespace {

constexpr int most_rounds = 12, evaluations_of_search = 300;
constexpr double settled = 0.01;        // gain of a round in ln p: a seventh of a sigma
constexpr double tolerance = 1e-3;      // of ln p, within a round
constexpr double largest_share = 0.1;   // refused, beyond which gates are left out of a round
constexpr double largest_error = 1e-4;  // of the sweep's gradient
constexpr int most_refreshes = 6;       // of what is accepted
constexpr int most_shrinkings = 3;      // of what gates accept, beyond which that feeds on itself
constexpr int most_scorings = 12;
constexpr double least_correlation = 1e-9;  // eigenvalue below which parameters act as one
constexpr double deepest_cut = 0.1;         // of g, in a step of scoring
constexpr double scored_share = 0.01;       // of its gain, below which a step of scoring is the last
constexpr double far_off = 10;   // gain of scoring beyond which the path itself will change: linearize again at once
constexpr double most_nis = 25;  // per row, beyond which R is far too small for the path to be of use
constexpr double least_weight = 0.3;  // of a parameter that says little
constexpr double curved_reach = 0.7;  // by which a round may change what noise is not affine in: a factor of 2

std::vector<double> picked(const std::vector<double>& all, const std::vector<std::size_t>& free) {
  std::vector<double> values;
  for (const std::size_t p : free) values.push_back(all[p]);
  return values;
}

Json counts_json(const Counts& counts) {
  return {{"samples", counts.samples},
          {"rows", counts.rows},
          {"refused", counts.refused},
          {"rows_refused", counts.rows_refused},
          {"recoveries", counts.recoveries}};
}

const char* gates_word(Gates gates) {
  return gates == Gates::off ? "off" : gates == Gates::frozen ? "frozen" : "as configured";
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
  if (is_frozen_) {
    round.gates = Gates::frozen;
    round.runs = runs_.record(u, Gates::frozen);
    round.counts = runs_.count(round.runs);
    return round;
  }
  bool is_broken = false;
  try {
    round.runs = runs_.record(u, Gates::as_configured);
    round.counts = runs_.count(round.runs);
  } catch (const FilterError&) {
    is_broken = true;
  }
  const Counts& counts = round.counts;
  if (is_broken || counts.rows_refused > largest_share * (counts.rows + counts.rows_refused)) {
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

void Search::check_gradient(const Linearized& log, const std::vector<double>& u) {
  gradient_error_ = std::max(gradient_error_, tune::gradient_error(log, u));
  if (gradient_error_ > largest_error)
    fallback_ = log.has_considered()
                    ? "with considered components gains are not optimal, and the sweep's gradient is not exact"
                    : "the sweep's gradient differs from differences of the likelihood";
}

Function Search::linearized(Found& found, Round round) {
  std::vector<Law> laws(laws_.size(), Law::none);
  for (const std::size_t p : found.free) laws[p] = laws_[p];
  runs_.add_slopes(round.runs, found.u, laws, round.gates);
  const auto log = std::make_shared<const Linearized>(plan_, std::move(round.runs), found.u, laws, options_.jobs);
  found.linearized = log;
  if (!is_checked_) check_gradient(*log, found.u);
  is_checked_ = true;
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

namespace {

/// d ln g / du.
double growth(Law law, const Parameter& parameter, double u) {
  const double value = parameter.value_of(u);
  return law_slope(law, parameter, value) / law_value(law, value);
}

/// I⁻¹ g by I's correlations, so that no parameter is too small to count. What would be cut below a tenth is cut to that,
/// and the others move as they do best then.
Eigen::VectorXd scoring_step(const Eigen::VectorXd& gradient, const Eigen::MatrixXd& information) {
  const Eigen::Index n = gradient.size();
  const Eigen::VectorXd size = information.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::MatrixXd correlation = size.cwiseInverse().asDiagonal() * information * size.cwiseInverse().asDiagonal();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(n);
  std::vector<bool> is_cut(static_cast<std::size_t>(n), false);
  for (bool is_new = true; is_new;) {
    is_new = false;
    Eigen::VectorXd right = gradient - information * step;
    Eigen::MatrixXd left = correlation;
    for (Eigen::Index i = 0; i < n; ++i) {
      right[i] /= size[i];
      if (!is_cut[static_cast<std::size_t>(i)]) continue;
      right[i] = 0;
      left.row(i).setZero();
      left.col(i).setZero();
    }
    const algebra::Spectrum spectrum = algebra::spectrum(left);
    Eigen::VectorXd along = spectrum.vectors.transpose() * right;
    for (Eigen::Index i = 0; i < n; ++i)
      along[i] = spectrum.values[i] > least_correlation ? along[i] / spectrum.values[i] : 0;
    step += (spectrum.vectors * along).cwiseQuotient(size);
    Eigen::VectorXd cut = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      if (is_cut[static_cast<std::size_t>(i)]) cut[i] = step[i];
      if (is_cut[static_cast<std::size_t>(i)] || step[i] >= deepest_cut - 1) continue;
      is_cut[static_cast<std::size_t>(i)] = is_new = true;
      cut[i] = deepest_cut - 1;
    }
    if (is_new) step = cut;
  }
  return step;
}

}  // namespace

/// The likelihood and the priors, with slopes and information by ln g.
double Search::informed(const Linearized& log, const std::vector<double>& u, Eigen::VectorXd& gradient,
                        Eigen::MatrixXd& information) {
  ++evaluations_;
  const double value = log.information(u, gradient, information);
  if (!std::isfinite(value)) return value;
  const auto noise = log.noise();
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const Parameter& parameter = plan_.parameters[noise[i]];
    if (!parameter.prior) continue;
    const double scale = parameter.prior->sigma * growth(laws_[noise[i]], parameter, u[noise[i]]);
    const auto k = static_cast<Eigen::Index>(i);
    gradient[k] -= (u[noise[i]] - parameter.prior->mean) / parameter.prior->sigma / scale;
    information(k, k) += 1 / (scale * scale);
  }
  return value - prior_cost(plan_, u, nullptr);
}

/// Fisher's scoring by g, in which the likelihood of a variance is nearly a parabola from above and from below: from a start
/// that is decades off it arrives in a few steps, where in ln g what is far too small has no slope.
std::vector<double> Search::approach(const Found& found, const Linearized& log, Function& function, double& gain) {
  auto u = found.u;
  const auto noise = log.noise();
  Eigen::VectorXd gradient;
  Eigen::MatrixXd information;
  double value = informed(log, u, gradient, information);
  const double start = value;
  for (int k = 0; k < most_scorings && std::isfinite(value); ++k) {
    const Eigen::VectorXd step = scoring_step(gradient, information);
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
      value = informed(log, next, gradient, information);
      if (value > before) break;
      for (std::size_t p = 0; p < u.size(); ++p) next[p] = 0.5 * (u[p] + next[p]);
    }
    if (!(value > before)) break;
    u = next;
    gain = value - start;
    if (value - before < std::max(settled, scored_share * gain)) break;
  }
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const Parameter& parameter = plan_.parameters[noise[i]];
    const double by_u = growth(laws_[noise[i]], parameter, u[noise[i]]);
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
                         "the objective has no value: no sample was withheld, or nothing was scored"});
    return value + (plan_.objective == Objective::metric ? 0 : prior_cost(plan_, at, nullptr));
  };
  return function;
}

Function Search::function_of(Found& found, Round round, std::vector<double>& start, double& gain) {
  const bool is_of_noise_alone = std::ranges::all_of(found.free, [&](std::size_t p) { return is_of_noise(laws_[p]); });
  Function function;
  if (is_of_noise_alone) {
    function = linearized(found, std::move(round));
    found.curvature_step = 1e-3;
  } else {
    if (!is_frozen_) runs_.freeze(round.runs);
    function = by_runs(found);
    found.curvature_step = 1e-2;
  }
  set_bounds(function, found);
  if (is_of_noise_alone) start = approach(found, *found.linearized, function, gain);
  return function;
}

/// A filter whose R is far too small may leave the truth altogether, and about such a path nothing is linear: R is raised
/// by as much as the NIS asks for, where that is likelier.
void Search::open_up(Found& found) {
  const auto measured = [&](const std::vector<double>& u, double& nis, double& likelihood) {
    const Round round = record(u);
    nis = round.counts.nis / std::max(1, round.counts.rows);
    likelihood = round.counts.likelihood;
    ++evaluations_;
  };
  double nis = 0, likelihood = 0;
  if (std::ranges::none_of(found.free, [&](std::size_t p) { return runs_.acts_on_R(p); })) return;
  measured(found.u, nis, likelihood);
  for (int k = 0; k < 3 && nis > most_nis; ++k) {
    auto u = found.u;
    for (const std::size_t p : found.free) {
      const Parameter& parameter = plan_.parameters[p];
      const double by = 0.5 * std::log(std::min(nis, 1e4)) * (laws_[p] == Law::linear ? 2 : 1);
      if (parameter.is_log && runs_.acts_on_R(p)) u[p] = std::min(u[p] + by, parameter.upper);
    }
    double next_nis = 0, next_likelihood = 0;
    measured(u, next_nis, next_likelihood);
    if (!(next_likelihood > likelihood)) return;
    found.u = u, nis = next_nis, likelihood = next_likelihood;
  }
}

/// Withheld samples or a metric, without a gradient.
void Search::judge_all(Found& found) {
  found.function = by_judgement(found);
  found.function.tolerance = plan_.objective == Objective::metric ? 0 : tolerance;
  found.curvature_step = 0.1;
  set_bounds(found.function, found);
  const Minimum minimum = minimize(found.function, picked(found.u, found.free), evaluations_of_search);
  evaluations_ += minimum.evaluations;
  found.u = expanded(found.u, found.free, minimum.u);
  found.cost = minimum.value;
  found.is_converged = minimum.is_converged;
  found.rounds.push_back({{"evaluations", minimum.evaluations}, {"start", minimum.first}, {"end", minimum.value}});
}

Found Search::from(std::vector<double> u, const std::vector<bool>& is_free) {
  Found found;
  found.u = std::move(u);
  for (std::size_t p = 0; p < is_free.size(); ++p)
    if (is_free[p]) found.free.push_back(p);
  if (plan_.objective == Objective::likelihood)
    search(found);
  else
    judge_all(found);
  return found;
}

/// By likelihood.
void Search::search(Found& found) {
  open_up(found);
  Counts last;
  Gates last_gates = Gates::off;
  int shrinkings = 0;  // one after the other
  for (int round = 0; round < most_rounds && !found.is_converged; ++round) {
    Round recorded = record(found.u);
    const Counts counts = recorded.counts;
    const Gates gates = recorded.gates;
    if (counts.rows == 0)
      throw FilterError({Severity::error, "B131", {}, "/tune", "no sample was accepted, so there is no likelihood"});
    if (gates == Gates::as_configured && !is_frozen_) {
      shrinkings = last_gates == Gates::as_configured && counts.rows < last.rows ? shrinkings + 1 : 0;
      if (shrinkings == 0) runs_.freeze(recorded.runs);
      is_frozen_ = shrinkings == most_shrinkings || round == most_refreshes;
      if (is_frozen_) continue;
    }
    const int before = evaluations_;
    std::vector<double> start = found.u;
    double scored = 0;
    found.function = function_of(found, std::move(recorded), start, scored);
    Minimum minimum{picked(start, found.free), 0, 0, 0, false};
    minimum.first = found.function.value(picked(found.u, found.free), nullptr);
    ++evaluations_;
    minimum.value = minimum.first - scored;
    if (scored < far_off) {
      const double first = minimum.first;
      minimum = minimize(found.function, minimum.u, evaluations_of_search);
      minimum.first = first;
      evaluations_ += minimum.evaluations;
    }
    found.u = expanded(found.u, found.free, minimum.u);
    found.cost = minimum.value;
    Json entry = {{"evaluations", evaluations_ - before},
                  {"start", minimum.first},
                  {"end", minimum.value},
                  {"gates", gates_word(gates)}};
    entry.update(counts_json(counts));
    found.rounds.push_back(entry);
    options_.on_round("round " + std::to_string(round + 1) + ": " + std::to_string(evaluations_ - before) +
                      " evaluations, " + std::to_string(counts.rows) + " rows, ln likelihood + " +
                      std::to_string(minimum.first - minimum.value));
    found.is_converged = round > 0 && minimum.first - minimum.value < settled && are_equal(counts, last);
    last = counts;
    last_gates = gates;
  }
}

}  // namespace binnacle::tune
