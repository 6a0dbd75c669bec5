// SPDX-License-Identifier: Apache-2.0
// IMU samples in other axes: the fixed rotation from sensor to vehicle axes.
#pragma once

#include <Eigen/Core>

#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::frames {

/// ω' = C ω, f' = C f with C = mounting_rotation. Mean rates of an interval are linear in its increments, so rotating
/// the rates is exact for a channel of increments too.
class RotateAxes final : public Transform {
 public:
  static ComponentSpec spec();
  explicit RotateAxes(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  /// C_nb′ = C_nb Cᵀ, and for an IMU that is mounted along the vehicle's axes C_v^b′ = C C_v^b, C_v^b = exp(−[ζ×]).
  void on_truth(const SampleView& sample, Emitter& emitter) const;

  Eigen::Matrix3d C_;
  Input imu_;
  Fields<3> w_, f_, attitude_, mounting_;
  OutputChannel turned_imu_, turned_truth_;
  OutputFields<3> turned_w_, turned_f_, turned_attitude_, turned_mounting_;
};

}  // namespace binnacle::frames
