// SPDX-License-Identifier: Apache-2.0
// The body: where the inertial sensor sits in the vehicle, and what it feels there of path, ride and engine.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "ride.hpp"
#include "trajectory.hpp"

namespace binnacle::vehicle_simulator {

/// Root mean squares per axis.
struct Shaking {
  double accel = 0;  // m/s²
  double rate = 0;   // rad/s
};

struct BodyModel {
  RideModel ride;
  Shaking standing, driving;
  double shaking_frequency = 25;                                 // Hz
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();           // m, vehicle axes, from the path's point to the IMU
  Eigen::Matrix3d nominal = Eigen::Matrix3d::Identity();         // M: IMU to vehicle axes, as it is thought to be
  Eigen::Vector3d misalignment = Eigen::Vector3d::Zero();        // rad, ζ: C_v^b = Mᵀ exp(−[ζ×])
  Eigen::Vector3d misalignment_sigma = Eigen::Vector3d::Zero();  // rad, drawn once a run and added to it
};

/// Plain memory.
struct BodyMemory {
  RideMemory ride;
  SplineMemory shaking[6];  // accelerations x y z, rates x y z
  double misalignment[3];   // rad, of this run
};

/// The IMU at one instant, in its own axes b.
struct ImuMotion {
  Eigen::Vector3d lla, v_n;
  Eigen::Vector3d roll_pitch_yaw;  // rad, of C_nb
  Eigen::Vector3d omega_ib_b;      // rad/s, without shaking
};

/// Where nothing of it is asked for, everything is the path's own, bit for bit.
class Body {
 public:
  Body(const BodyModel& model, const std::vector<Segment>& segments);

  BodyMemory start(std::uint64_t seed) const;
  ImuMotion motion(const Trajectory& trajectory, double t, BodyMemory& memory) const;
  /// ∫ ω_ib_b dt and ∫ f_b dt over [t0, t1]. What the lever arm adds to f is ω̇ × l + ω × (ω × l) in vehicle axes, and the
  /// difference of gravity by height. The shaking is a small motion about the sensor that is felt and not reported:
  /// 0.3 m/s² at 25 Hz are 12 µm.
  Inertial increments(const Trajectory& trajectory, double t0, double t1, BodyMemory& memory) const;

 private:
  Eigen::Matrix3d C_bv(const BodyMemory& memory) const;
  Motion ridden(const Trajectory& trajectory, double t, BodyMemory& memory) const;
  void shake(const Trajectory& trajectory, double t, double sign, BodyMemory& memory, Inertial& sum) const;

  BodyModel model_;
  Ride ride_;
  SplineNoise shaking_;
  bool is_plain_, has_lever_arm_, is_mounted_, shakes_;
};

}  // namespace binnacle::vehicle_simulator
