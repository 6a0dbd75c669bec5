// SPDX-License-Identifier: Apache-2.0
// The body: where the inertial sensor sits in the vehicle, and what it feels there of path, ride and engine.
#include "body.hpp"

#include <cstddef>

#include <Eigen/Geometry>

#include "simulation/sensor_errors.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::vehicle_simulator {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d attitude_matrix(const Vector3d& roll_pitch_yaw) {
  return strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(roll_pitch_yaw));
}

}  // namespace

Body::Body(const BodyModel& model, const std::vector<Segment>& segments)
    : model_(model),
      ride_(model.ride, segments),
      shaking_(model.shaking_frequency),
      has_lever_arm_(!model.lever_arm.isZero(0.0)),
      is_mounted_(!model.nominal.isIdentity(0.0) || !model.misalignment.isZero(0.0) ||
                  !model.misalignment_sigma.isZero(0.0)),
      shakes_(model.standing.accel > 0 || model.standing.rate > 0 || model.driving.accel > 0 ||
              model.driving.rate > 0) {
  is_plain_ = ride_.is_still() && !has_lever_arm_ && !is_mounted_ && !shakes_;
}

BodyMemory Body::start(std::uint64_t seed) const {
  BodyMemory memory{};
  memory.ride = Ride::start(seed);
  static constexpr const char* streams[] = {"shaking.ax", "shaking.ay", "shaking.az",
                                            "shaking.wx", "shaking.wy", "shaking.wz"};
  for (std::size_t i = 0; i < std::size(streams); ++i) memory.shaking[i] = SplineNoise::start(seed, streams[i]);
  Eigen::Map<Vector3d>(memory.misalignment) =
      model_.misalignment +
      model_.misalignment_sigma.cwiseProduct(simulation::first_normal_vector(seed, "misalignment"));
  return memory;
}

Matrix3d Body::C_bv(const BodyMemory& memory) const {
  const Vector3d zeta = Eigen::Map<const Vector3d>(memory.misalignment);
  return model_.nominal.transpose() * strapdown::dcm_from_quaternion(strapdown::quaternion_exp(-zeta));
}

Motion Body::ridden(const Trajectory& trajectory, double t, BodyMemory& memory) const {
  Motion motion = trajectory.motion(t);
  if (!ride_.is_still()) ride_.apply(t, trajectory.course(t), motion, memory.ride);
  return motion;
}

ImuMotion Body::motion(const Trajectory& trajectory, double t, BodyMemory& memory) const {
  const Motion vehicle = ridden(trajectory, t, memory);
  ImuMotion imu{vehicle.lla, vehicle.v_n, vehicle.roll_pitch_yaw, inertial(vehicle).omega_ib_b};
  if (has_lever_arm_) {
    const Matrix3d C_nv = attitude_matrix(vehicle.roll_pitch_yaw);
    const Vector3d omega_ev = imu.omega_ib_b - C_nv.transpose() * strapdown::omega_ie_n(vehicle.lla[0]);
    imu.lla = strapdown::position_plus(vehicle.lla, C_nv * model_.lever_arm);
    imu.v_n += C_nv * omega_ev.cross(model_.lever_arm);
  }
  if (is_mounted_) {
    const Matrix3d C = C_bv(memory);
    const Matrix3d C_nb = attitude_matrix(vehicle.roll_pitch_yaw) * C.transpose();
    imu.roll_pitch_yaw = strapdown::euler_from_quaternion(strapdown::quaternion_from_dcm(C_nb));
    imu.omega_ib_b = C * imu.omega_ib_b;
  }
  return imu;
}

Inertial Body::increments(const Trajectory& trajectory, double t0, double t1, BodyMemory& memory) const {
  if (is_plain_) return trajectory.increments(t0, t1);
  Inertial sum{Vector3d::Zero(), Vector3d::Zero()};
  trajectory.for_each_instant(t0, t1, [&](double t, double weight, Motion at, const Course& course) {
    if (!ride_.is_still()) ride_.apply(t, course, at, memory.ride);
    Inertial now = inertial(at);
    if (has_lever_arm_) {
      const Matrix3d C_nv = attitude_matrix(at.roll_pitch_yaw);
      const double higher = -(C_nv * model_.lever_arm)[2];  // m
      const double more_gravity = strapdown::gravity(at.lla[0], at.lla[2]).d_height * higher;
      now.f_b += now.omega_ib_b.cross(now.omega_ib_b.cross(model_.lever_arm)) - more_gravity * C_nv.row(2).transpose();
    }
    sum.omega_ib_b += weight * now.omega_ib_b;
    sum.f_b += weight * now.f_b;
  });
  if (has_lever_arm_) {
    const auto omega = [&](double t) { return inertial(ridden(trajectory, t, memory)).omega_ib_b; };
    const Vector3d at_begin = omega(t0), at_end = omega(t1);
    sum.f_b += (at_end - at_begin).cross(model_.lever_arm);
  }
  if (is_mounted_) {
    const Matrix3d C = C_bv(memory);
    sum = {C * sum.omega_ib_b, C * sum.f_b};
  }
  if (shakes_) {
    shake(trajectory, t0, -1.0, memory, sum);
    shake(trajectory, t1, 1.0, memory, sum);
  }
  return sum;
}

void Body::shake(const Trajectory& trajectory, double t, double sign, BodyMemory& memory, Inertial& sum) const {
  const double share = ride_.share(trajectory.course(t).speed);
  const double accel = model_.standing.accel + share * (model_.driving.accel - model_.standing.accel);
  const double rate = model_.standing.rate + share * (model_.driving.rate - model_.standing.rate);
  for (int i = 0; i < 3; ++i) {
    sum.f_b[i] += sign * accel * shaking_.at(t, memory.shaking[i]).value;
    sum.omega_ib_b[i] += sign * rate * shaking_.at(t, memory.shaking[3 + i]).value;
  }
}

}  // namespace binnacle::vehicle_simulator
