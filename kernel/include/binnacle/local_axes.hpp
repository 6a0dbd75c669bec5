// SPDX-License-Identifier: Apache-2.0
// Local north, east, down of an origin, and the parameter that says where it is. Header-only.
#pragma once

#include <numbers>
#include <string>
#include <utility>

#include <Eigen/Core>

#include "binnacle/geodesy.hpp"
#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"

namespace binnacle {
namespace geodesy {

/// The same vector in east, north, up for one in north, east, down; its own inverse.
inline Eigen::Vector3d enu_from_ned(const Eigen::Vector3d& v) { return {v[1], v[0], -v[2]}; }

/// Local Cartesian axes: north, east, down of the ellipsoid at an origin, straight on from there (a tangent plane: 10 km away
/// the ellipsoid is 7.8 m below it). Positions are metres from the origin: p_l = C_le (r_e − r_e,origin), C_le = C_enᵀ of the
/// origin; Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 2.1.
class LocalAxes {
 public:
  LocalAxes() : LocalAxes({0, 0, 0}) {}
  /// The origin's latitude [rad], longitude [rad], height [m].
  explicit LocalAxes(const Eigen::Vector3d& origin)
      : r_origin_(geodesy::ecef_from_lla(origin)), C_el_(C_en(origin[0], origin[1])) {}

  /// Metres north, east, down of the origin for a position (rad, rad, m), and back.
  Eigen::Vector3d ned_from_lla(const Eigen::Vector3d& lla) const { return ned_from_ecef(ecef_from_lla(lla)); }
  Eigen::Vector3d lla_from_ned(const Eigen::Vector3d& p_l) const { return lla_from_ecef(ecef_from_ned(p_l)); }
  /// For an earth-centred position [m], and back.
  Eigen::Vector3d ned_from_ecef(const Eigen::Vector3d& r_e) const { return C_el_.transpose() * (r_e - r_origin_); }
  Eigen::Vector3d ecef_from_ned(const Eigen::Vector3d& p_l) const { return r_origin_ + C_el_ * p_l; }
  /// C_nl: from the local axes to north, east, down of the place `lla`. It differs from the identity by the distance over the
  /// earth's radius: 1.6 mrad at 10 km; in azimuth by as much times tan(latitude).
  Eigen::Matrix3d C_nl(const Eigen::Vector3d& lla) const { return C_en(lla[0], lla[1]).transpose() * C_el_; }

 private:
  Eigen::Vector3d r_origin_;  // ECEF [m]
  Eigen::Matrix3d C_el_;
};

}  // namespace geodesy
namespace parameter {

/// A geodetic point on WGS 84: {"lat", "lon", "height"}. lla_of() reads it.
inline ParameterSpec point(std::string name) {
  constexpr double degree = std::numbers::pi / 180;
  return object(std::move(name),
                {number("lat", "rad").at_least(-90 * degree).at_most(90 * degree).required().about("geodetic latitude"),
                 number("lon", "rad").at_least(-360 * degree).at_most(360 * degree).required().about("east positive"),
                 number("height", "m").plausible(0, 1e5).required().about("above the ellipsoid")});
}

/// Where local north, east, down begin: the component's own "origin", or that at the top of the config. Where neither is there
/// it is absent, which local_axes_of() refuses in words. (A default that is a JSON pointer is what stands there in the config.)
inline ParameterSpec origin() {
  return point("origin").defaults("/origin").about("where local north, east, down begin; else the config's own");
}

}  // namespace parameter

/// (latitude rad, longitude rad, height m) of the members of a parameter::point().
inline Eigen::Vector3d lla_of(const Parameters& point) {
  return {point.number("lat"), point.number("lon"), point.number("height")};
}

/// Axes of parameter::origin(). Throws ComponentError where no place has one; `who` needs it, and stands at `pointer`.
inline geodesy::LocalAxes local_axes_of(const Parameters& parameters, const std::string& who,
                                        const std::string& pointer = {}) {
  if (!parameters.has("origin"))
    throw ComponentError(who +
                             " need an origin: \"origin\": {\"lat\": \"49.01 deg\", \"lon\": \"8.43 deg\", "
                             "\"height\": \"115 m\"}, here or at the top of the config (/origin)",
                         pointer);
  return geodesy::LocalAxes(lla_of(parameters.object("origin")));
}

}  // namespace binnacle
