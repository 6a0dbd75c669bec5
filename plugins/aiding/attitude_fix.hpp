// SPDX-License-Identifier: Apache-2.0
// An attitude that another system gives.
#pragma once

#include <Eigen/Core>

#include "binnacle/measurement_model.hpp"
#include "binnacle/spec.hpp"
#include "deviations.hpp"

namespace binnacle::aiding {

/// q_z = exp(v) ⊗ q_nb, v about north, east, down [rad].
///     r = log(q_z ⊗ q̂*)      H = J_l⁻¹(−r), which leaves r as it is: H r = r
class AttitudeFix final : public MeasurementModel {
 public:
  static ComponentSpec spec();
  explicit AttitudeFix(const Binding& binding);

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 private:
  enum class Form { quaternion, dcm, angles };
  /// Why it is no attitude, or null.
  const char* read(const SampleView& sample, Eigen::Vector4d& q_nb) const;

  Port attitude_;
  Fields<4> quaternion_;
  Fields<9> dcm_;  // row by row
  Fields<3> angles_;
  Form form_ = Form::quaternion;
  Deviations sigma_;
};

}  // namespace binnacle::aiding
