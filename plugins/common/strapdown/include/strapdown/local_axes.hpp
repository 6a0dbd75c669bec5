// SPDX-License-Identifier: Apache-2.0
// How north, east, down turn as the place changes.
#pragma once

#include <Eigen/Core>

#include <cmath>

#include "strapdown/earth.hpp"

namespace binnacle::strapdown {

/// dθ/dδ [rad/m], δ in north, east, down: (1/(R_t+h) east, −1/(R_m+h) north, −tan L/(R_t+h) east), the transport rate per
/// metre. ∂(C_en v_n)/∂δ = C_en [dθ/dδ × v_n].
inline Eigen::Matrix3d axes_per_metre(const Eigen::Vector3d& lla) {
  const Radii R = radii(lla[0]);
  const double east = 1 / (R.transverse + lla[2]);
  Eigen::Matrix3d dtheta = Eigen::Matrix3d::Zero();
  dtheta(0, 1) = east;
  dtheta(1, 0) = -1 / (R.meridian + lla[2]);
  dtheta(2, 1) = -std::tan(lla[0]) * east;
  return dtheta;
}

/// A way of some metres north, east, down from a place, by position_plus(), and what becomes of an error of the place and of
/// the way, each in metres north, east, down where it stands: δ⁺ = by_place δ + by_way δ_way. Both differ from the identity
/// by the way over the earth's radius.
struct Advance {
  Eigen::Vector3d lla;
  Eigen::Matrix3d by_place;
  Eigen::Vector3d by_way;  // the diagonal
};
inline Advance advance(const Eigen::Vector3d& lla, const Eigen::Vector3d& way) {
  Advance result{position_plus(lla, way), Eigen::Matrix3d::Identity(), Eigen::Vector3d::Ones()};
  const Radii R = radii(lla[0]), R_after = radii(result.lla[0]);
  const double meridian = R.meridian + lla[2], transverse = R.transverse + lla[2];
  const double north = (R_after.meridian + result.lla[2]) / meridian;
  const double east = (R_after.transverse + result.lla[2]) * std::cos(result.lla[0]) / (transverse * std::cos(lla[0]));
  // position_plus divides the way by radii that themselves depend on the place; ⊟ multiplies by those where it ends.
  result.by_place(0, 0) = north * (1 - way[0] * R.d_meridian / (meridian * meridian));
  result.by_place(0, 2) = north * way[0] / meridian;
  result.by_place(1, 0) = east * way[1] * (std::tan(lla[0]) - R.d_transverse / transverse) / meridian;
  result.by_place(1, 1) = east;
  result.by_place(1, 2) = east * way[1] / transverse;
  result.by_way << north, east, 1;
  return result;
}

}  // namespace binnacle::strapdown
