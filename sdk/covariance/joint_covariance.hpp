// SPDX-License-Identifier: Apache-2.0
// The joint covariance of what is true and what a filter with other beliefs makes of it, source by source.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "binnacle/composition.hpp"

namespace binnacle::covariance {

/// z = (true state, estimate), both as deviations from the error-free run. Every source of error (initial values, the
/// noise of some blocks, that of a measurement) has a covariance of its own, so that their sum is the truth and the parts
/// are its budget. Source: Gelb (ed.), Applied Optimal Estimation, 1974, section 7.2.
class JointCovariance {
 public:
  JointCovariance(const FilterInfo& truth, const FilterInfo& model);

  void start(const Eigen::MatrixXd& P_true);
  /// Truth and filter each step as they do: what is between two updates is theirs alone.
  void step_truth(const Eigen::MatrixXd& Phi, const Eigen::MatrixXd& Q);
  void step_model(const Eigen::MatrixXd& Phi);
  /// Estimate += K (H_true x + v − H_model estimate), E[v vᵀ] = R_true; `name` is the measurement's.
  void update(const std::string& name, const Eigen::MatrixXd& H_true, const Eigen::MatrixXd& R_true,
              const Eigen::MatrixXd& H_model, const Eigen::MatrixXd& K);

  int true_size() const { return true_size_; }
  int model_size() const { return model_size_; }
  const std::vector<std::string>& sources() const { return names_; }
  /// The variance of c·z by source.
  Eigen::VectorXd variance(const Eigen::VectorXd& c) const;
  int source(const std::string& name);

 private:
  void name_process_noise(const Eigen::MatrixXd& Q);

  int true_size_, model_size_;
  std::vector<std::string> block_of_row_;  // of the truth
  std::vector<int> source_of_row_;         // process noise; −1: not yet known
  std::vector<std::string> names_;
  std::vector<Eigen::MatrixXd> J_;
};

}  // namespace binnacle::covariance
