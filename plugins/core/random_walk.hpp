// SPDX-License-Identifier: Apache-2.0
// A vector driven by white noise.
#pragma once

#include <vector>

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = w, E[w wᵀ] = diag(q²) δ(t), so Φ = I and Qd = diag(q²) dt.
class RandomWalk final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit RandomWalk(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;
  void linearized(const ContinuousInput& in, ContinuousOutput& out) const override;

 private:
  Port x_;
  QBlock q_;
  std::vector<double> density_;  // q² [unit²/s]
};

}  // namespace binnacle::core
