// SPDX-License-Identifier: Apache-2.0
// The stance_detector transform: from the inertial samples of a foot to a channel that emits while it stands.
#pragma once

#include <Eigen/Core>

#include "binnacle/source.hpp"

namespace binnacle::stationary_detector {

/// The generalized likelihood ratio test of Skog et al. (2010), called SHOE there: over the last W samples
///   T = 1/W Σ ( |f_k − g f̄/|f̄||² / σ_f² + |ω_k|² / σ_ω² ) < γ
/// Channels: "standing" (the rates of the newest sample) at each sample whose window passes, and "state" (standing: 1 or 0,
/// and T) at each full window. A hole in the samples empties the window, and none emits until it is full again.
class StanceDetector final : public Transform {
 public:
  static ComponentSpec spec();
  explicit StanceDetector(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

  static constexpr int most_samples = 128;

 private:
  struct Memory;

  void declare_channels();
  void on_imu(const SampleView& sample, Memory& memory, Emitter& emitter) const;
  double statistic(const Memory& memory) const;

  int samples_;         // W
  double force_sigma_;  // m/s²
  double rate_sigma_;   // rad/s
  double gravity_;      // m/s²
  double threshold_;    // γ
  Time max_gap_;
  Input imu_, gyro_bias_;
  Fields<3> w_, f_, bias_;
  OutputChannel standing_channel_, state_channel_;
  OutputFields<3> standing_w_, standing_f_;
  OutputField is_standing_, statistic_;
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::stationary_detector
