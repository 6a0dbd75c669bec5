// SPDX-License-Identifier: Apache-2.0
// Plain state blocks of the kinds position and attitude, written from the definition of the kinds alone.
#pragma once

#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "binnacle/kind_blocks.hpp"

namespace binnacle::testing {

/// "position": latitude, longitude [rad], height [m]; error north, east, down [m] by WGS-84's radii of curvature.
class PositionKind final : public KindBlock {
 public:
  PositionKind() : KindBlock("position", 3, {{"north", "m"}, {"east", "m"}, {"down", "m"}}) {}
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    const auto [north, east] = metres_per_radian(x);
    const double lat = x[0] + delta[0] / north, lon = x[1] + delta[1] / east, height = x[2] - delta[2];
    result[0] = lat, result[1] = std::remainder(lon, 2 * M_PI), result[2] = height;
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    const auto [north, east] = metres_per_radian(x);
    const double down = x[2] - y[2];
    delta[0] = (y[0] - x[0]) * north, delta[1] = std::remainder(y[1] - x[1], 2 * M_PI) * east, delta[2] = down;
  }

 private:
  static std::pair<double, double> metres_per_radian(ConstVectorView x) {
    const double a = 6378137.0, f = 1 / 298.257223563, e2 = f * (2 - f);
    const double w = std::sqrt(1 - e2 * std::sin(x[0]) * std::sin(x[0]));
    return {a * (1 - e2) / (w * w * w) + x[2], (a / w + x[2]) * std::cos(x[0])};
  }
};

/// "attitude": quaternion (w, x, y, z) body to navigation; q_true = exp(phi) ⊗ q̂.
class AttitudeKind final : public KindBlock {
 public:
  AttitudeKind() : KindBlock("attitude", 4, {{"north", "rad"}, {"east", "rad"}, {"down", "rad"}}) {}
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    const Eigen::Vector3d phi = delta.as<3>();
    const double angle = phi.norm();
    const Eigen::Vector3d axis = angle > 0 ? Eigen::Vector3d(phi / angle) : Eigen::Vector3d(1, 0, 0);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, axis));
    store((turn * load(x)).normalized(), result);
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    Eigen::Quaterniond turn = load(y) * load(x).conjugate();
    if (turn.w() < 0) turn.coeffs() *= -1;
    const double sine = turn.vec().norm();
    const double per_sine = sine > 0 ? 2 * std::atan2(sine, turn.w()) / sine : 2;
    delta.as<3>() = per_sine * turn.vec();
  }

 private:
  static Eigen::Quaterniond load(ConstVectorView x) { return {x[0], x[1], x[2], x[3]}; }
  static void store(const Eigen::Quaterniond& q, VectorView x) {
    x[0] = q.w(), x[1] = q.x(), x[2] = q.y(), x[3] = q.z();
  }
};

}  // namespace binnacle::testing
