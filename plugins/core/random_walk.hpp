// SPDX-License-Identifier: Apache-2.0
// A vector driven by white noise.
#pragma once

#include <vector>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = w, E[w wᵀ] = diag(q²) δ(t), so Φ = I and Qd = diag(q²) dt.
class RandomWalk final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit RandomWalk(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  Result propagate(const Step& step, const double* const* x, std::byte* memory,
                   const legacy::ProcessOutput& out) const override;
  void linearized(const double* const* x, const legacy::ContinuousOutput& out) const override;

 private:
  ProcessDeclaration declaration_;
  std::vector<double> density_;  // q² [unit²/s]
};

}  // namespace binnacle::core
