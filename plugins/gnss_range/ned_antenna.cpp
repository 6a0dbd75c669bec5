// SPDX-License-Identifier: Apache-2.0
// An ECEF position and velocity as blocks of the geodetic kinds.
#include "ned_antenna.hpp"

#include <Eigen/Geometry>

#include "antenna.hpp"
#include "binnacle/view.hpp"
#include "strapdown/local_axes.hpp"

namespace binnacle::gnss_range {

namespace {

constexpr const char* blocks_example = R"json({"blocks": {
    "r": {"type": "gnss_range/ecef_position", "init": {"x": -3976219, "y": 3382371, "z": 3652511}, "sigma": "10 m"},
    "v": {"type": "gnss_range/ecef_velocity", "init": {"vx": 1, "vy": 2, "vz": 3}, "sigma": "1 m/s"}}})json";

bool is_near_earth(ConstVectorView ecef) {
  const auto r = ecef.as<3>();
  return r.allFinite() && r.cwiseAbs().maxCoeff() < 1e8 && r.norm() > 5e6 && r.head<2>().norm() > 1;
}

constexpr const char* not_near = "the position is not near the earth's surface, or is at a pole";

}  // namespace

ComponentSpec GeodeticPosition::spec() {
  ComponentSpec spec;
  spec.type = "geodetic_position";
  spec.summary = "An ECEF position as latitude, longitude and height, for models that need this kind.";
  spec.source = "paper 003, equation (6)";
  spec.kind = "position";
  spec.ports = {reads("ecef_position", "position.ecef").about("the position in ECEF axes")};
  spec.example = R"json({"blocks": {"ecef_position": "r"}})json";
  spec.surroundings = blocks_example;
  return spec;
}

GeodeticPosition::GeodeticPosition(const Binding& binding) : ecef_position_(binding.port("ecef_position")) {
  declaration_.yields("position", 3, {{"north", "m"}, {"east", "m"}, {"down", "m"}}).reads(ecef_position_);
}

Result GeodeticPosition::evaluate(const DerivedInput& in, DerivedOutput& out) const {
  if (!is_near_earth(in.x[ecef_position_])) return Result::unsupported(not_near);
  const gnss::AntennaPlace place = gnss::place_from_ecef(in.x[ecef_position_].as<3>());
  out.value.as<3>() = place.lla;
  if (const MatrixView J = out.J[ecef_position_]) J.as<3, 3>() = place.C_en.transpose();
  return Result::ok();
}

ComponentSpec NedVelocity::spec() {
  ComponentSpec spec;
  spec.type = "ned_velocity";
  spec.summary = "An ECEF velocity in north, east, down axes, for models that need this kind.";
  spec.source = "paper 003, equation (8)";
  spec.kind = "velocity.ned";
  spec.ports = {reads("ecef_position", "position.ecef").about("position at which the axes are defined"),
                reads("ecef_velocity", "velocity.ecef").about("the velocity in ECEF axes")};
  spec.example = R"json({"blocks": {"ecef_position": "r", "ecef_velocity": "v"}})json";
  spec.surroundings = blocks_example;
  return spec;
}

NedVelocity::NedVelocity(const Binding& binding)
    : ecef_position_(binding.port("ecef_position")), ecef_velocity_(binding.port("ecef_velocity")) {
  declaration_.yields("velocity.ned", 3, {{"north", "m/s"}, {"east", "m/s"}, {"down", "m/s"}});
  declaration_.reads(ecef_position_).reads(ecef_velocity_);
}

Result NedVelocity::evaluate(const DerivedInput& in, DerivedOutput& out) const {
  if (!is_near_earth(in.x[ecef_position_])) return Result::unsupported(not_near);
  const gnss::AntennaPlace place = gnss::place_from_ecef(in.x[ecef_position_].as<3>());
  const Eigen::Matrix3d C_ne = place.C_en.transpose();
  const Eigen::Vector3d v = C_ne * in.x[ecef_velocity_].as<3>();
  out.value.as<3>() = v;
  if (out.J) {
    const Eigen::Matrix3d dtheta = strapdown::axes_per_metre(place.lla);
    Eigen::Matrix3d turned;  // d(C_ne v_e) = −dθ × v_n
    for (int i = 0; i < 3; ++i) turned.col(i) = v.cross(dtheta.col(i));
    out.J[ecef_position_].as<3, 3>() = turned * C_ne;
    out.J[ecef_velocity_].as<3, 3>() = C_ne;
  }
  return Result::ok();
}

}  // namespace binnacle::gnss_range
