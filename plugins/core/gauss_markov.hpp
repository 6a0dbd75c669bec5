// SPDX-License-Identifier: Apache-2.0
// First-order Gauss–Markov process.
#pragma once

#include <vector>

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = −x/τ + w per component, with E[w²] = 2σ²/τ δ(t), so that σ is the standard deviation in the steady state:
/// Φ = exp(−dt/τ), Qd = σ² (1 − exp(−2 dt/τ)).
class GaussMarkov final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit GaussMarkov(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;
  void linearized(const ContinuousInput& in, ContinuousOutput& out) const override;

 private:
  struct Component {
    double tau;       // s
    double variance;  // unit²
  };
  Port x_;
  PhiBlock phi_;
  QBlock q_;
  std::vector<Component> components_;
};

}  // namespace binnacle::core
