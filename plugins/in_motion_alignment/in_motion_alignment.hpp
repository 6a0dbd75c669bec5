// SPDX-License-Identifier: Apache-2.0
// The in_motion_alignment transform: attitude of an IMU that moves, from GNSS velocities over a window.
#pragma once

#include <optional>
#include <string>

#include "binnacle/source.hpp"
#include "window.hpp"

namespace binnacle::in_motion_alignment {

struct State;

/// Channels: "" (roll, pitch, yaw; covariance in the attitude's error dof) and "gyro_bias" (x, y, z with covariance).
/// All of its state is plain memory.
class InMotionAlignment final : public Transform {
 public:
  static ComponentSpec spec();
  explicit InMotionAlignment(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;
  std::string waits_for(const MemoryView& memory) const override;

 private:
  void initialise(std::uint64_t seed, const MemoryView& memory) const override;
  void declare_channels();
  void on_imu(const SampleView& sample, State& state) const;
  void on_gnss(const SampleView& sample, State& state, Emitter& emitter) const;
  bool is_good(const Fit& fit, State& state) const;
  void emit(Time t, const Fit& fit, Emitter& emitter) const;

  Time length_ = 0, every_ = 0;
  double largest_heading_sd_ = 0;  // rad
  double largest_misfit_ = 0;
  std::optional<double> velocity_sd_;  // m/s
  Priors priors_;
  Course course_;
  Input imu_, gnss_;
  Fields<3> w_, f_, velocity_, reported_sd_;
  OutputChannel attitude_channel_, gyro_bias_channel_;
  OutputFields<3> attitude_, gyro_bias_;
  Memory<State> state_;
};

}  // namespace binnacle::in_motion_alignment
