// SPDX-License-Identifier: Apache-2.0
// The classical coning motion, with a shaking in its rhythm, in inertial axes or at a place on the earth.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "simulation/kinematics.hpp"

namespace binnacle::coning_simulator {

struct Cone {
  double half_angle;  // rad
  double frequency;   // Hz
};

/// a(t) = amplitude · cos(W t + phase) in navigation axes; displacement and velocity without a constant part.
struct Shaking {
  Eigen::Vector3d amplitude = Eigen::Vector3d::Zero();  // m/s²
  double phase = 0.0;                                   // rad
};

/// With ε the half-angle and W = 2π f the attitude is
///     q(t) = (cos ε/2, 0, sin ε/2 cos W t, sin ε/2 sin W t)        whose change over h is paper 002, equation (8),
/// with P₁ = −sin²(ε/2) sin W h (as printed it lacks the sign), so against the axes it is given in
///     ω(t) = (−2 W sin² ε/2, −W sin ε sin W t, W sin ε cos W t).
/// At a place the axes are north, east, down there, and the sensors feel the earth's rotation and gravity as well.
class ConingMotion {
 public:
  ConingMotion(const Cone& cone, const Shaking& shaking, const std::optional<Eigen::Vector3d>& place);

  /// Times count in cycles, reduced to [0, 1): a phase that has not lost digits to the hours behind it.
  Eigen::Vector4d attitude(double cycle) const;
  Eigen::Vector3d velocity(double cycle) const;
  Eigen::Vector3d position(double cycle) const;  // latitude, longitude, height; only at a place

  /// ∫ω dt and ∫f dt over `length` [s] around `middle`. Without place and shaking in closed form, else what these add by
  /// Gauss–Legendre quadrature to the last digits.
  simulation::Inertial increments(double middle, double length) const;

 private:
  Eigen::Matrix3d C_nb(double cycle) const;
  Eigen::Vector3d acceleration(double cycle) const;
  Eigen::Vector3d displacement(double cycle) const;
  simulation::Inertial beyond_the_cone(double cycle) const;

  Cone cone_;
  Shaking shaking_;
  std::optional<Eigen::Vector3d> place_;
  double omega_;  // rad/s
  double sin_half_, cos_half_, sin_cone_;
};

}  // namespace binnacle::coning_simulator
