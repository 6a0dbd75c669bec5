// SPDX-License-Identifier: Apache-2.0
// The integral of another vector.
#pragma once

#include <vector>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = rate + w, E[w wᵀ] = diag(q²) δ(t). Only the continuous form is given: the kernel discretizes it together with
/// the process of `rate`, and so Qd has the cross terms that integration brings.
class Integrated final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit Integrated(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  void linearized(const double* const* x, const legacy::ContinuousOutput& out) const override;

 private:
  ProcessDeclaration declaration_;
  int dof_;
  std::vector<double> density_;  // q² [unit²/s]; empty: no noise of its own
};

}  // namespace binnacle::core
