// SPDX-License-Identifier: Apache-2.0
// An attitude moved by gyro increments alone.
#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "attitude/algorithm.hpp"
#include "binnacle/legacy.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::attitude_only {

/// q ← q ⊗ q(φ), φ by the attitude algorithm chosen (paper 002). The axes that the attitude is told in do not turn, so the
/// error stands still, Φ = I, and grows by the gyros' white noise: Q = C diag(n²) Cᵀ dt, C at the step's begin.
class AttitudeOnly final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec();
  explicit AttitudeOnly(const Binding& binding);

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  Result propagate(const Step& step, const double* const* x, std::byte* memory,
                   const legacy::ProcessOutput& out) const override;

 private:
  ProcessDeclaration declaration_;
  attitude::Algorithm algorithm_;
  Eigen::Vector3d density_;  // rad²/s
};

}  // namespace binnacle::attitude_only
