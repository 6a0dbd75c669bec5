// SPDX-License-Identifier: Apache-2.0
// The integral of another vector.
#pragma once

#include <vector>

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::core {

/// ẋ = rate + w, E[w wᵀ] = diag(q²) δ(t). Only the continuous form is given: the kernel discretizes it together with
/// the process of `rate`, and so Qd has the cross terms that integration brings.
class Integrated final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit Integrated(const Binding& binding);

  void linearized(const ContinuousInput& in, ContinuousOutput& out) const override;

 private:
  Port x_;
  PhiBlock rate_in_;
  QBlock q_;
  std::vector<double> density_;  // q² [unit²/s]; empty: no noise of its own
};

}  // namespace binnacle::core
