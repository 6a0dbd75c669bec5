// SPDX-License-Identifier: Apache-2.0
// The coarse_alignment transform: the first attitude, by levelling at rest and one of three ways to a heading.
#pragma once

#include <optional>
#include <string>

#include "binnacle/source.hpp"
#include "rest_window.hpp"

namespace binnacle::coarse_alignment {

enum class Heading { given, course, gyrocompass };

struct Settings {
  Heading heading = Heading::given;
  double yaw = 0;                  // rad
  double sigma_heading = 0;        // rad
  std::optional<double> latitude;  // rad
  RestLimits rest;
  double max_speed = 0;               // m/s, of a GNSS velocity at rest
  double min_speed = 0;               // m/s, for a course
  double max_turn_rate = 0;           // rad/s, for a course
  double slip_lever_arm = 0;          // m
  std::optional<double> velocity_sd;  // m/s
  Time max_coast = 0;
  std::optional<Time> every;
  double accelerometer_bias = 0;  // m/s²
  double gyro_bias = 0;           // rad/s
  double gyro_drift = 0;          // rad/s
  double gyro_misalignment = 0;   // rad/rad
};

struct State;

/// Channels: "" (roll, pitch, yaw; covariance in the attitude's error dof) and "gyro_bias" (x, y, z with covariance).
/// All of its state is plain memory.
class CoarseAlignment final : public Transform {
 public:
  static ComponentSpec spec();
  explicit CoarseAlignment(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;
  std::string waits_for(const MemoryView& memory) const override;

 private:
  void initialise(std::uint64_t seed, const MemoryView& memory) const override;
  void declare_channels();
  void on_imu(const SampleView& sample, State& state, Emitter& emitter) const;
  void on_gnss(const SampleView& sample, State& state, Emitter& emitter) const;
  void level(Time t, State& state) const;
  void gyrocompass(Time t, const RestMeans& means, State& state) const;
  double course_variance(const SampleView& sample, double turn_rate) const;
  std::optional<double> latitude(const State& state) const;
  std::string no_rest(const RestFindings& rest, double spacing) const;
  void emit(Time t, State& state, Emitter& emitter) const;
  void emit_gyro_bias(Time t, const State& state, Emitter& emitter) const;

  Settings settings_;
  Input imu_, gnss_;
  Fields<3> w_, f_;
  Fields<2> velocity_, velocity_sd_;  // north, east
  Field latitude_;
  OutputChannel attitude_channel_, gyro_bias_channel_;
  OutputFields<3> attitude_, gyro_bias_;
  Memory<State> state_;
};

}  // namespace binnacle::coarse_alignment
