// SPDX-License-Identifier: Apache-2.0
// The likelihood of all runs about one place of u, for any noise.
#pragma once

#include <vector>

#include "optimizer.hpp"
#include "runs.hpp"

namespace binnacle::tune {

class Linearized {
 public:
  /// Of runs that were recorded at u. `laws`: those of parameters without slopes are not of noise.
  Linearized(const Plan& plan, std::vector<MemberRun> runs, std::vector<double> u, std::vector<Law> laws, int jobs)
      : plan_(plan), runs_(std::move(runs)), u_(std::move(u)), laws_(std::move(laws)), jobs_(jobs) {}

  /// Σ over all logs, at another u that differs in noise alone; gradient (as long as u) by the sweep.
  double likelihood(const std::vector<double>& u, double* gradient) const;
  /// The likelihood, and of the parameters of noise its gradient and Fisher's information by ln g, g what the noise is affine
  /// in: as long as noise().
  double information(const std::vector<double>& u, Eigen::VectorXd& gradient, Eigen::MatrixXd& information) const;
  /// Which parameters are of noise.
  std::vector<std::size_t> noise() const;
  /// The same by central differences.
  void differences(const std::vector<double>& u, double* gradient) const;

  const std::vector<double>& u() const { return u_; }
  const std::vector<Law>& laws() const { return laws_; }
  const std::vector<MemberRun>& runs() const { return runs_; }
  bool has_considered() const;

 private:
  std::vector<double> changes(const std::vector<double>& u) const;
  std::vector<const LinearLog*> logs() const;

  const Plan& plan_;
  std::vector<MemberRun> runs_;
  std::vector<double> u_;
  std::vector<Law> laws_;
  int jobs_;
};

/// The sweep against differences: the largest difference over 1 + the largest slope.
double gradient_error(const Linearized& linearized, const std::vector<double>& u);

/// −ln of the priors' density but for constants; adds its slopes.
double prior_cost(const Plan& plan, const std::vector<double>& u, double* gradient);

}  // namespace binnacle::tune
