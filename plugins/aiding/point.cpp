// SPDX-License-Identifier: Apache-2.0
// Points outside: geodetic, earth-centred or local coordinates, in the axes in which a sensor's place is.
#include "point.hpp"

#include <numbers>

namespace binnacle::aiding {

namespace {

using strapdown::PlaceKind;

constexpr std::array<std::array<const char*, 3>, 3> all_names = {
    {{"lat", "lon", "height"}, {"x", "y", "z"}, {"north", "east", "down"}}};

std::string joined(const std::array<const char*, 3>& words) {
  return std::string(words[0]) + ", " + words[1] + ", " + words[2];
}

}  // namespace

const std::array<const char*, 3>& coordinate_names(PlaceKind kind) { return all_names[static_cast<std::size_t>(kind)]; }

std::vector<ParameterSpec> point_parameters() {
  using parameter::number;
  constexpr double quarter = std::numbers::pi / 2;
  return {number("lat", "rad").at_least(-quarter).at_most(quarter).about("geodetic latitude, WGS-84"),
          number("lon", "rad").at_least(-4 * quarter).at_most(4 * quarter).about("longitude, east positive"),
          number("height", "m").plausible(0, 1e8).about("height above the ellipsoid"),
          number("x", "m").about("ECEF"),
          number("y", "m").about("ECEF"),
          number("z", "m").about("ECEF"),
          number("north", "m").about("local north, from the origin"),
          number("east", "m").about("local east"),
          number("down", "m").about("local down; default: 0 if the sensor's position is a vector of two")};
}

SensorPlace::SensorPlace(const Binding& binding, const char* port) : port_(binding.port(port)) {
  const std::string& kind = binding.block(port).kind;
  const auto found = strapdown::place_kind(kind);
  if (!found || port_.dof() < 2)
    throw ComponentError("a place is of the kind 'position', 'position.ecef', 'vector:2:m' or 'vector:3:m'; found '" +
                             kind + "'",
                         std::string("/blocks/") + port);
  kind_ = *found;
  if (binding.parameters().has("origin")) local_ = local_axes_of(binding.parameters(), "");
}

void SensorPlace::demand(PlaceKind given, const std::string& pointer) const {
  if (local_ || (given == PlaceKind::local) == (kind_ == PlaceKind::local)) return;
  const char* const who = given == PlaceKind::local ? "local points (north, east, down) for a place on the earth"
                                                    : "points on the earth for a local place";
  local_axes_of({}, who, pointer);  // throws: there is none
}

Eigen::Vector3d SensorPlace::bring(const Point& point) const {
  if (point.kind == PlaceKind::local)
    return kind_ == PlaceKind::local ? point.coordinates : local_->ecef_from_ned(point.coordinates);
  const Eigen::Vector3d r_e =
      point.kind == PlaceKind::geodetic ? strapdown::ecef_from_lla(point.coordinates) : point.coordinates;
  return kind_ == PlaceKind::local ? local_->ned_from_ecef(r_e) : r_e;
}

std::optional<Point> SensorPlace::read(const Parameters& object, const std::string& pointer) const {
  std::optional<Point> point;
  for (const PlaceKind kind : {PlaceKind::geodetic, PlaceKind::ecef, PlaceKind::local}) {
    const auto& names = coordinate_names(kind);
    const bool is_planar = kind == PlaceKind::local && kind_ == PlaceKind::local && port_.dof() == 2;
    Eigen::Vector3d coordinates = Eigen::Vector3d::Zero();
    int count = 0, needed = is_planar ? 2 : 3;
    std::string missing;
    for (int i = 0; i < 3; ++i) {
      const char* const name = names[static_cast<std::size_t>(i)];
      if (object.has(name))
        coordinates[i] = object.number(name), ++count;
      else if (i < needed && missing.empty())
        missing = name;
    }
    if (count == 0) continue;
    if (!missing.empty()) throw ComponentError("missing key '" + missing + "': a point is " + joined(names), pointer);
    if (point)
      throw ComponentError("the point is given twice: by " + joined(coordinate_names(point->kind)) + " and by " +
                               joined(names),
                           pointer);
    point = Point{kind, coordinates};
  }
  if (point) demand(point->kind, pointer);
  return point;
}

}  // namespace binnacle::aiding
