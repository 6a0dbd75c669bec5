// SPDX-License-Identifier: Apache-2.0
// LocalFrame: north, east and down at a place, straight axes that do not turn with the vehicle.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "convert/track.hpp"

namespace binnacle::convert {

class LocalFrame {
 public:
  explicit LocalFrame(const Place& origin);

  /// d = C_en(origin)' (r - r_origin) [m], of earth-centred, earth-fixed r.
  Eigen::Vector3d ned(const Eigen::Vector3d& ecef) const { return C_en_.transpose() * (ecef - origin_); }
  Eigen::Vector3d ecef(const Eigen::Vector3d& ned) const { return origin_ + C_en_ * ned; }

 private:
  Eigen::Vector3d origin_;
  Eigen::Matrix3d C_en_;
};

/// "origin" of a run's config. Throws Refusal where it is not what a run takes.
std::optional<Place> origin_of(const results::Json& config);

}  // namespace binnacle::convert
