// SPDX-License-Identifier: Apache-2.0
// The ports by which a model learns where the antenna is and how it moves: geodetic or earth-centred.
#pragma once

#include <Eigen/Core>

#include "binnacle/binding.hpp"
#include "binnacle/model_input.hpp"
#include "binnacle/result.hpp"
#include "binnacle/spec.hpp"
#include "gnss/corrections.hpp"

namespace binnacle::gnss_range {

std::vector<PortSpec> position_ports();
std::vector<PortSpec> velocity_ports();

/// Exactly one of `position` (kind position) and `ecef_position` is bound.
class AntennaPosition {
 public:
  explicit AntennaPosition(const Binding& binding);
  Port port() const noexcept { return port_; }
  Result read(const PortValues& x, gnss::AntennaPlace& place) const;
  /// What ∂/∂r_e becomes in the error of the port that is bound.
  Eigen::RowVector3d by_error(const gnss::AntennaPlace& place, const Eigen::RowVector3d& by_ecef) const;

 private:
  Port port_;
  bool is_ecef_;
};

/// Exactly one of `velocity` (kind velocity.ned) and `ecef_velocity` is bound; the frame is the position's.
class AntennaVelocity {
 public:
  explicit AntennaVelocity(const Binding& binding);
  Port port() const noexcept { return port_; }
  Eigen::Vector3d read(const PortValues& x, const gnss::AntennaPlace& place) const;
  Eigen::RowVector3d by_error(const gnss::AntennaPlace& place, const Eigen::RowVector3d& by_ecef) const;
  /// What ∂/∂v_e brings to the error of the position: north, east, down axes turn with it. In ECEF.
  Eigen::RowVector3d by_position(const PortValues& x, const gnss::AntennaPlace& place,
                                 const Eigen::RowVector3d& by_ecef) const;

 private:
  Port port_;
  bool is_ecef_;
};

}  // namespace binnacle::gnss_range
