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

}  // namespace binnacle::strapdown
