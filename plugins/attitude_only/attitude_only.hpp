// SPDX-License-Identifier: Apache-2.0
// An attitude moved by gyro increments alone.
#pragma once

#include <Eigen/Core>

#include "attitude/algorithm.hpp"
#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"
#include "inertial/sample_memory.hpp"

namespace binnacle::attitude_only {

/// q ← q ⊗ q(φ), φ by the attitude algorithm chosen (paper 002). The axes that the attitude refers to do not turn, so the
/// error stands still, Φ = I, and grows by the gyros' white noise: Q = C diag(n²) Cᵀ dt, C at the step's begin.
class AttitudeOnly final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit AttitudeOnly(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 private:
  Port attitude_;
  inertial::SensorFields fields_;
  QBlock q_;
  Memory<inertial::SampleMemory> memory_;
  attitude::Algorithm algorithm_;
  Eigen::Vector3d density_;  // rad²/s
};

}  // namespace binnacle::attitude_only
