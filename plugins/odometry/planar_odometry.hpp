// SPDX-License-Identifier: Apache-2.0
// Dead reckoning on the ground: speed and yaw rate drive position and heading.
#pragma once

#include <Eigen/Core>

#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::odometry {

/// Speed z_v and yaw rate z_ω, means over the interval of the driving input, move the vehicle along an arc in the plane
/// that touches the ellipsoid's normal at its place:
///     v = z_v / (1 + s)      ω = ±z_ω − b + Ω sin L      p⁺ = p ⊞ arc(ψ, v, ω, dt)      ψ⁺ = ψ + ω dt + east tan L/(R_t + h)
/// s and b: ports `scale` and `yaw_rate_bias`. Ω sin L only with `earth_rate`. The last term is how north turns as one
/// goes east. The height stays.
class PlanarOdometry final : public ProcessModel {
 public:
  static ComponentSpec spec();
  explicit PlanarOdometry(const Binding& binding);

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 private:
  /// Position as the bound block stores it, and the heading.
  struct Pose {
    Eigen::Vector3d position;
    double yaw;
  };
  /// ∂ by the errors of (position, heading, scale, bias).
  using Jacobian = Eigen::Matrix<double, 4, 6>;
  struct Parts;
  struct Moved;

  Moved move(const Pose& pose, double scale, double bias, const InputSample& sample) const;
  void differentiate(const Parts& parts, Moved& moved) const;
  Eigen::Matrix4d noise(const Parts& parts, const InputSample& sample) const;
  void write(const Jacobian& J, const Eigen::Matrix4d& Q, ProcessOutput& out) const;

  Port position_, heading_, scale_, bias_;
  bool is_ecef_;
  Field speed_, yaw_rate_;
  double turn_;  // +1: a positive yaw rate is clockwise seen from above
  bool feels_earth_;
  double S_speed_, S_distance_, S_side_, S_height_, S_yaw_, S_turn_;  // squares of the parameters
  double bridge_acceleration_, bridge_rate_;                          // m/s², rad/s
  PhiBlock phi_pp_, phi_ph_, phi_ps_, phi_pb_, phi_hp_, phi_hh_, phi_hs_, phi_hb_;
  QBlock q_pp_, q_ph_, q_hh_;
};

}  // namespace binnacle::odometry
