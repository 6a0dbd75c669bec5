// SPDX-License-Identifier: Apache-2.0
#include "joint_covariance.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::covariance {

using Eigen::MatrixXd;
using Eigen::VectorXd;

JointCovariance::JointCovariance(const FilterInfo& truth, const FilterInfo& model)
    : true_size_(truth.dof), model_size_(model.dof), block_of_row_(static_cast<std::size_t>(truth.dof)) {
  for (const auto& block : truth.blocks)
    for (std::size_t i = 0; i < block.active.size(); ++i)
      block_of_row_[static_cast<std::size_t>(block.first_row) + i] = block.name;
}

int JointCovariance::source(const std::string& name) {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found != names_.end()) return static_cast<int>(found - names_.begin());
  names_.push_back(name);
  J_.push_back(MatrixXd::Zero(true_size_ + model_size_, true_size_ + model_size_));
  return static_cast<int>(names_.size()) - 1;
}

void JointCovariance::start(const MatrixXd& P_true) {
  J_[static_cast<std::size_t>(source("initial values"))].topLeftCorner(true_size_, true_size_) = P_true;
}

/// Rows whose noise is correlated have it from one source; it is named after their blocks.
void JointCovariance::name_process_noise(const MatrixXd& Q) {
  constexpr double correlated = 1e-6;
  const auto rows = static_cast<std::size_t>(true_size_);
  std::vector<std::size_t> first(rows);
  for (std::size_t i = 0; i < rows; ++i) {
    first[i] = i;
    for (std::size_t j = 0; j < i; ++j) {
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      const bool is_one = block_of_row_[i] == block_of_row_[j] ||
                          std::abs(Q(a, b)) > correlated * std::sqrt(std::abs(Q(a, a) * Q(b, b)));
      if (!is_one) continue;
      const std::size_t joined = std::min(first[i], first[j]), other = std::max(first[i], first[j]);
      std::replace(first.begin(), first.begin() + static_cast<std::ptrdiff_t>(i) + 1, other, joined);
    }
  }
  source_of_row_.assign(rows, -1);
  for (std::size_t i = 0; i < rows; ++i) {
    if (first[i] != i) continue;
    std::string name, last;
    double noise = 0;
    for (std::size_t j = i; j < rows; ++j) {
      if (first[j] != i) continue;
      noise += Q(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(j));
      if (block_of_row_[j] != last) name += (name.empty() ? "process noise of " : ", ") + block_of_row_[j];
      last = block_of_row_[j];
    }
    if (noise == 0) continue;
    const int index = source(name);
    for (std::size_t j = i; j < rows; ++j)
      if (first[j] == i) source_of_row_[j] = index;
  }
}

void JointCovariance::step_truth(const MatrixXd& Phi, const MatrixXd& Q) {
  if (source_of_row_.empty()) name_process_noise(Q);
  for (auto& J : J_) {
    J.topRows(true_size_) = (Phi * J.topRows(true_size_)).eval();
    J.leftCols(true_size_) = (J.leftCols(true_size_) * Phi.transpose()).eval();
  }
  for (Eigen::Index i = 0; i < true_size_; ++i)
    for (Eigen::Index j = 0; j < true_size_; ++j) {
      if (Q(i, j) == 0) continue;
      int index = source_of_row_[static_cast<std::size_t>(std::min(i, j))];
      if (index < 0) index = source("process noise");
      J_[static_cast<std::size_t>(index)](i, j) += Q(i, j);
    }
}

void JointCovariance::step_model(const MatrixXd& Phi) {
  for (auto& J : J_) {
    J.bottomRows(model_size_) = (Phi * J.bottomRows(model_size_)).eval();
    J.rightCols(model_size_) = (J.rightCols(model_size_) * Phi.transpose()).eval();
  }
}

void JointCovariance::update(const std::string& name, const MatrixXd& H_true, const MatrixXd& R_true,
                             const MatrixXd& H_model, const MatrixXd& K) {
  const int index = source("noise of " + name);
  const Eigen::Index all = true_size_ + model_size_;
  MatrixXd A = MatrixXd::Identity(all, all);
  A.bottomLeftCorner(model_size_, true_size_) = K * H_true;
  A.bottomRightCorner(model_size_, model_size_) -= K * H_model;
  for (auto& J : J_) J = (A * J * A.transpose()).eval();
  J_[static_cast<std::size_t>(index)].bottomRightCorner(model_size_, model_size_) += K * R_true * K.transpose();
}

VectorXd JointCovariance::variance(const VectorXd& c) const {
  VectorXd parts(static_cast<Eigen::Index>(J_.size()));
  for (std::size_t s = 0; s < J_.size(); ++s) parts[static_cast<Eigen::Index>(s)] = c.dot(J_[s] * c);
  return parts;
}

}  // namespace binnacle::covariance
