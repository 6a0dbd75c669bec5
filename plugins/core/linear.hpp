// SPDX-License-Identifier: Apache-2.0
// Any linear time-invariant process, by its matrices.
#pragma once

#include <Eigen/Core>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = F x + G w, E[w wᵀ] = diag(q²) δ(t); discretized by the kernel.
class Linear final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit Linear(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  void linearized(const double* const* x, const legacy::ContinuousOutput& out) const override;

 private:
  ProcessDeclaration declaration_;
  Eigen::MatrixXd F_;    // 1/s
  Eigen::MatrixXd GQG_;  // G diag(q²) Gᵀ [unit²/s]; empty: no noise
};

}  // namespace binnacle::core
