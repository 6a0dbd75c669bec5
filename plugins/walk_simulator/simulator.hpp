// SPDX-License-Identifier: Apache-2.0
// The source: a walk as an inertial sensor on the foot measures it, truth, and an initial estimate.
#pragma once

#include <memory>

#include <Eigen/Core>

#include "binnacle/source.hpp"
#include "simulation/clock.hpp"
#include "simulation/fields.hpp"
#include "simulation/sensor_errors.hpp"
#include "walk.hpp"

namespace binnacle::walk_simulator {

class WalkSimulator final : public Source {
 public:
  static ComponentSpec spec();
  explicit WalkSimulator(const Binding& binding);

  SourceStatus next(const MemoryView& bytes, SourceOutput& out) const override;

  enum Channel { imu, truth, initial };  // the order of its channels

 private:
  struct Memory;

  void initialise(std::uint64_t seed, const MemoryView& bytes) const override;
  explicit WalkSimulator(const Parameters& parameters);
  void declare_channels();
  void emit_imu(Memory& memory, SampleWriter& out) const;
  void emit_truth(Memory& memory, SampleWriter& out) const;
  void emit_initial(Memory& memory, SampleWriter& out) const;

  std::unique_ptr<const Walk> walk_;
  Time start_time_, end_;
  simulation::Clock imu_clock_, truth_clock_;
  bool emits_rates_, is_perfect_;
  simulation::SensorModel gyro_, accel_;
  Eigen::Matrix<double, 9, 1> sigma_;  // of the estimate: position NED m, velocity NED m/s, attitude NED rad
  OutputChannel imu_channel_, truth_channel_, initial_channel_;
  simulation::ImuFields imu_;
  OutputFields<3> position_, velocity_, attitude_, gyro_bias_, accel_bias_;
  OutputField standing_;
  OutputFields<3> initial_position_, initial_velocity_, initial_attitude_;
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::walk_simulator
