// SPDX-License-Identifier: Apache-2.0
// Rounds of optimization, each about the path of the last, until neither moves.
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "judge.hpp"
#include "linearized.hpp"
#include "optimizer.hpp"
#include "runs.hpp"

namespace binnacle::tune {

/// Where a start led.
struct Found {
  std::vector<double> u;                                  // of all parameters
  double cost = std::numeric_limits<double>::infinity();  // −ln of the posterior density, or the objective
  bool is_converged = false;
  Json rounds = Json::array();
  std::vector<std::size_t> free;  // those that were searched
  Function function;              // of the free ones, about the end
  double curvature_step = 1e-3;
  std::shared_ptr<const Linearized> linearized;  // null where no likelihood is linearized
};

class Search {
 public:
  Search(const Plan& plan, const TuneOptions& options, Runs& runs, std::vector<Law> laws);

  /// What is accepted stays frozen from one call to the next, once it is.
  Found from(std::vector<double> u, const std::vector<bool>& is_free);
  int evaluations() const { return evaluations_; }
  /// Why differences stand in for the sweep; empty where they do not.
  const std::string& fallback() const { return fallback_; }
  double gradient_error() const { return gradient_error_; }
  /// The sweep's gradient there against differences: what goes into gradient_error() and fallback().
  void check_gradient(const Linearized& log, const std::vector<double>& u);

 private:
  struct Round {
    std::vector<MemberRun> runs;
    Gates gates = Gates::as_configured;
    Counts counts;
  };
  Round record(const std::vector<double>& u);
  /// About the runs' path.
  Function linearized(Found& found, Round round);
  /// Scoring from where the round begins, for the optimizer to begin at; and the weights there.
  std::vector<double> approach(const Found& found, const Linearized& log, Function& function, double& gain);
  double informed(const Linearized& log, const std::vector<double>& u, Eigen::VectorXd& gradient,
                  Eigen::MatrixXd& information);
  void open_up(Found& found);
  /// By runs whose accepted samples are frozen.
  Function by_runs(const Found& found);
  Function by_judgement(const Found& found);
  void judge_all(Found& found);
  void search(Found& found);
  double judged(const std::vector<double>& u) const;
  void set_bounds(Function& function, const Found& found) const;
  Function function_of(Found& found, Round round, std::vector<double>& start, double& gain);

  const Plan& plan_;
  const TuneOptions& options_;
  Runs& runs_;
  std::vector<Law> laws_;
  int evaluations_ = 0;
  bool is_checked_ = false;
  bool is_frozen_ = false;  // what is accepted, for the rest of the rounds
  std::string fallback_;
  double gradient_error_ = 0;
};

/// The free ones of u replaced.
std::vector<double> expanded(const std::vector<double>& u, const std::vector<std::size_t>& free,
                             const std::vector<double>& values);

}  // namespace binnacle::tune
