// SPDX-License-Identifier: Apache-2.0
// The ports by which a model learns where the antenna is and how it moves.
#include "antenna.hpp"

#include <Eigen/Geometry>

#include <cmath>

#include "binnacle/eigen.hpp"
#include "binnacle/view.hpp"
#include "strapdown/local_axes.hpp"

namespace binnacle::gnss_range {

namespace {

/// The one that is bound.
Port one_of(const Binding& binding, const char* ned, const char* ecef) {
  if (binding.port(ned).is_bound() == binding.port(ecef).is_bound())
    throw ComponentError(std::string("plug a block into one of the ports '") + ned + "' and '" + ecef + "'", "/blocks");
  return binding.port(binding.port(ecef).is_bound() ? ecef : ned);
}

constexpr double least_radius = 5e6;  // m from the earth's centre; nearer to it directions mean nothing

}  // namespace

std::vector<PortSpec> position_ports() {
  return {reads("position", "position")
              .optional()
              .about("position of the antenna: a position block or a lever_arm; alternative to ecef_position"),
          reads("ecef_position", "position.ecef")
              .optional()
              .about("position of the antenna in ECEF axes; alternative to position")};
}

std::vector<PortSpec> velocity_ports() {
  return {reads("velocity", "velocity.ned")
              .optional()
              .about("velocity of the antenna: a velocity block or a lever_arm_velocity; alternative to ecef_velocity"),
          reads("ecef_velocity", "velocity.ecef")
              .optional()
              .about("velocity of the antenna in ECEF axes; alternative to velocity")};
}

AntennaPosition::AntennaPosition(const Binding& binding)
    : port_(one_of(binding, "position", "ecef_position")), is_ecef_(binding.port("ecef_position").is_bound()) {}

Result AntennaPosition::read(const PortValues& x, gnss::AntennaPlace& place) const {
  const auto value = x[port_].as<3>();
  if (!value.allFinite()) return Result::invalid("the position is not finite");
  if (is_ecef_) {
    if (value.cwiseAbs().maxCoeff() > 1e8 || value.norm() < least_radius)
      return Result::unsupported("the antenna is not near the earth's surface");
    place = gnss::place_from_ecef(value);
  } else {
    if (std::abs(value[0]) > M_PI / 2 || std::abs(value[2]) > 1e6)
      return Result::unsupported("the antenna is not near the earth's surface");
    place = gnss::place_from_lla(value);
  }
  return Result::ok();
}

Eigen::RowVector3d AntennaPosition::by_error(const gnss::AntennaPlace& place, const Eigen::RowVector3d& by_ecef) const {
  return is_ecef_ ? by_ecef : Eigen::RowVector3d(by_ecef * place.C_en);
}

AntennaVelocity::AntennaVelocity(const Binding& binding)
    : port_(one_of(binding, "velocity", "ecef_velocity")), is_ecef_(binding.port("ecef_velocity").is_bound()) {
  if (is_ecef_ != binding.port("ecef_position").is_bound())
    throw ComponentError("position and velocity are in different axes: plug both into 'ecef_…' ports, or neither",
                         "/blocks");
}

Eigen::Vector3d AntennaVelocity::read(const PortValues& x, const gnss::AntennaPlace& place) const {
  const Eigen::Vector3d v = x[port_].as<3>();
  return is_ecef_ ? v : Eigen::Vector3d(place.C_en * v);
}

Eigen::RowVector3d AntennaVelocity::by_error(const gnss::AntennaPlace& place, const Eigen::RowVector3d& by_ecef) const {
  return is_ecef_ ? by_ecef : Eigen::RowVector3d(by_ecef * place.C_en);
}

Eigen::RowVector3d AntennaVelocity::by_position(const PortValues& x, const gnss::AntennaPlace& place,
                                                const Eigen::RowVector3d& by_ecef) const {
  if (is_ecef_) return Eigen::RowVector3d::Zero();
  const Eigen::Vector3d v = x[port_].as<3>();
  // d(C_en v) = C_en (dθ × v); as a row on δ in north, east, down, and from there to ECEF.
  const Eigen::Matrix3d dtheta = strapdown::axes_per_metre(place.lla);
  Eigen::Matrix3d turned;
  for (int i = 0; i < 3; ++i) turned.col(i) = dtheta.col(i).cross(v);
  return by_ecef * place.C_en * turned * place.C_en.transpose();
}

}  // namespace binnacle::gnss_range
