// SPDX-License-Identifier: Apache-2.0
// The stationary_detector transform: from inertial samples to channels that emit while the vehicle stands or moves.
#pragma once

#include "binnacle/source.hpp"
#include "motion_window.hpp"

namespace binnacle::stationary_detector {

struct Settings {
  WindowSettings window;
  double rate_threshold = 0;           // rad/s
  double specific_force_variance = 0;  // (m/s²)²
  double on = 0, off = 0;              // s
  Time max_gap = 0;
  double standing_period = 0, moving_period = 0;  // s
};

/// Channels: "standing" and "moving" (mean rates over the interval that the statement is about), of which one emits at
/// a time, and "state" (standing: 1 or 0) at every decision. Before the first decision, and after a gap, none emits.
class StationaryDetector final : public Transform {
 public:
  static ComponentSpec spec();
  explicit StationaryDetector(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  struct Memory;

  void declare_channels();
  void on_imu(const SampleView& sample, Memory& memory, Emitter& emitter) const;
  bool looks_still(const Memory& memory) const;
  void decide(Time t, Memory& memory, Emitter& emitter) const;
  void emit_state(Time t, Memory& memory, Emitter& emitter) const;

  Settings settings_;
  Input imu_, gyro_bias_;
  Fields<3> w_, f_, bias_;
  struct Mean {
    OutputChannel channel;
    OutputFields<3> w, f;
  };
  Mean standing_, moving_;
  OutputChannel state_channel_;
  OutputField is_standing_;
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::stationary_detector
