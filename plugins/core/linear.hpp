// SPDX-License-Identifier: Apache-2.0
// Any linear time-invariant process, by its matrices.
#pragma once

#include <Eigen/Core>

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = F x + G w, E[w wᵀ] = diag(q²) δ(t); discretized by the kernel.
class Linear final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit Linear(const Binding& binding);

  void linearized(const ContinuousInput& in, ContinuousOutput& out) const override;

 private:
  PhiBlock F_block_;
  QBlock GQG_block_;
  Eigen::MatrixXd F_;    // 1/s
  Eigen::MatrixXd GQG_;  // G diag(q²) Gᵀ [unit²/s]; empty: no noise
};

}  // namespace binnacle::core
