// SPDX-License-Identifier: Apache-2.0
// The source: a ship in waves as samples of a master INS, of a slave's inertial sensors, and truth.
#pragma once

#include <Eigen/Core>

#include "binnacle/source.hpp"
#include "declaration.hpp"
#include "ship_motion.hpp"
#include "simulation/clock.hpp"
#include "simulation/sensor_errors.hpp"

namespace binnacle::ship_simulator {

/// Standard deviations: white errors of each sample and constant errors of a run.
struct MinsModel {
  Eigen::Vector3d velocity_noise = Eigen::Vector3d::Zero(), velocity_bias = Eigen::Vector3d::Zero();  // m/s, NED
  Eigen::Vector3d attitude_noise = Eigen::Vector3d::Zero(), attitude_bias = Eigen::Vector3d::Zero();  // rad, Euler
  Eigen::Vector3d position_noise = Eigen::Vector3d::Zero(), position_bias = Eigen::Vector3d::Zero();  // m, NED
};

struct MountingModel {
  Eigen::Vector4d nominal;       // q of C_S^M
  Eigen::Vector3d misalignment;  // rad, MINS axes
  Eigen::Vector3d sigma;         // rad; added to it
  Eigen::Vector3d lever_arm;     // m, MINS axes
};

struct InitialModel {
  bool is_from_mins;
  Eigen::Matrix<double, 9, 1> error, sigma;  // position m, velocity m/s, attitude rad; north, east, down
};

/// What the SINS' attitude is: true mounting = nominal ⊞ m, C_S^M = exp([m×]) nominal, m in MINS axes. Paper 000 (3) has
/// Ĉ_S^M = (I − [δμ×]) C_S^M, so its δμ is what is missing of m: m = m̂ + δμ to first order.
class ShipSimulator final : public Source {
 public:
  static ComponentSpec spec();
  explicit ShipSimulator(const Binding& binding);

  SourceStatus next(const MemoryView& bytes, SourceOutput& out) const override;

  enum Channel { imu, mins, truth, initial, mounting };  // the order of its channels

 private:
  struct Memory;

  void initialise(std::uint64_t seed, const MemoryView& bytes) const override;

  explicit ShipSimulator(const Parameters& parameters);
  simulation::Inertial increments(double t0, double t1, const double* phases) const;
  Eigen::Vector3d rotation_since(Eigen::Vector4d& last, double t, const double* phases) const;
  void emit_imu(Memory& memory, const double* phases, SampleWriter& out) const;
  void emit_mins(Memory& memory, const double* phases, SampleWriter& out) const;
  void emit_truth(Memory& memory, const double* phases, SampleWriter& out) const;
  void emit_mounting(Memory& memory, SampleWriter& out) const;
  void emit_initial(Memory& memory, const double* phases, SampleWriter& out) const;

  ShipMotion motion_;
  Time start_time_, duration_;
  simulation::Clock imu_clock_, mins_clock_, truth_clock_;
  bool has_rotation_vectors_;
  simulation::SensorModel gyro_, accel_;
  MinsModel mins_;
  MountingModel mounting_;
  InitialModel initial_;
  double longest_piece_;  // s, of an interval under quadrature
  Channels channels_;
  binnacle::Memory<Memory> memory_;
  MemoryArray<double> phases_;  // of the tones
};

}  // namespace binnacle::ship_simulator
