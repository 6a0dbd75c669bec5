// SPDX-License-Identifier: Apache-2.0
// First-order Gauss–Markov process.
#pragma once

#include <vector>

#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = −x/τ + w per component, with E[w²] = 2σ²/τ δ(t), so that σ is the standard deviation in the steady state:
/// Φ = exp(−dt/τ), Qd = σ² (1 − exp(−2 dt/τ)).
class GaussMarkov final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit GaussMarkov(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  Result propagate(const Step& step, const double* const* x, std::byte* memory,
                   const legacy::ProcessOutput& out) const override;
  void linearized(const double* const* x, const legacy::ContinuousOutput& out) const override;

 private:
  struct Component {
    double tau;       // s
    double variance;  // unit²
  };
  ProcessDeclaration declaration_;
  std::vector<Component> components_;
};

}  // namespace binnacle::core
