// SPDX-License-Identifier: Apache-2.0
// The source: a drive along segments as IMU samples, GNSS fixes, truth, and an initial estimate.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "binnacle/source.hpp"
#include "body.hpp"
#include "declaration.hpp"
#include "simulation/clock.hpp"
#include "simulation/sensor_errors.hpp"
#include "trajectory.hpp"

namespace binnacle::vehicle_simulator {

struct GnssModel {
  Eigen::Vector3d position_error;     // m, standard deviations north, east, down
  Eigen::Vector3d velocity_error;     // m/s
  Eigen::Vector3d position_reported;  // m, as the receiver states them
  Eigen::Vector3d velocity_reported;  // m/s
  Eigen::Vector3d lever_arm_b;        // m, from the IMU to the antenna, body axes
};

struct InitialModel {
  Eigen::Matrix<double, 9, 1> sigma;  // position NED m, velocity NED m/s, attitude NED rad
  bool is_perfect;                    // the estimate is the truth; the covariance is as if it were not
};

class VehicleSimulator final : public Source {
 public:
  static ComponentSpec spec();
  explicit VehicleSimulator(const Binding& binding);

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& bytes, SourceOutput& out) const override;

  enum Channel { imu, gnss, truth, initial };  // the order of its channels

 private:
  struct Memory;

  void initialise(std::uint64_t seed, const MemoryView& bytes) const override;

  explicit VehicleSimulator(const Parameters& parameters);
  void emit_imu(Memory& memory, SampleWriter& out) const;
  void emit_gnss(Memory& memory, SampleWriter& out) const;
  void emit_truth(Memory& memory, SampleWriter& out) const;
  void emit_initial(Memory& memory, SampleWriter& out) const;

  std::vector<Segment> segments_;
  Start start_;
  Suspension suspension_;
  Body body_;
  Time start_time_;
  simulation::Clock imu_clock_, gnss_clock_, truth_clock_;
  bool emits_rates_;
  simulation::SensorModel gyro_, accel_;
  GnssModel gnss_;
  InitialModel initial_;
  Channels channels_;
  binnacle::Memory<Memory> memory_;
  std::unique_ptr<const Trajectory> trajectory_;  // made by open(), never changed afterwards
};

}  // namespace binnacle::vehicle_simulator
