// SPDX-License-Identifier: Apache-2.0
// csv: columns in local axes become geodetic positions, and velocities of the place.
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "binnacle/composition.hpp"
#include "catch.hpp"
#include "csv_files.hpp"

namespace csv_local_test {

using namespace binnacle;
using namespace binnacle::csv_files;
using binnacle::test::Contains;
using Eigen::Vector3d;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

Json origin() { return object({{"lat", 49.01 * degree}, {"lon", 8.43 * degree}, {"height", 115}}); }

Json metres(const std::string& name, double scale = 1) {
  return object({{"column", name}, {"unit", unit("m", scale)}});
}
Json speed(const std::string& name) { return object({{"column", name}, {"unit", unit("m/s")}}); }

Json local(const std::string& path, Members members) {
  return with_member(with_member(parameters(path, {}), "local", object(std::move(members))), "origin", origin());
}

/// Where a point lies that is some metres from the origin, computed here from the ellipsoid alone.
Vector3d ecef(double lat, double lon, double height) {
  constexpr double a = 6378137.0, f = 1 / 298.257223563, e2 = f * (2 - f);
  const double N = a / std::sqrt(1 - e2 * std::sin(lat) * std::sin(lat));
  return {(N + height) * std::cos(lat) * std::cos(lon), (N + height) * std::cos(lat) * std::sin(lon),
          (N * (1 - e2) + height) * std::sin(lat)};
}

}  // namespace

TEST_CASE("csv reads local north, east, down, and east, north, up alike", "[csv]") {
  const TemporaryFile file("t,x,y,z,down,vx,vy,vz\n0,1200,-3400,56,-56,5,6,1\n1,0,0,0,0,0,0,0\n");
  const auto enu = read(local(file.path(), {{"east", metres("x")}, {"north", metres("y")}, {"up", metres("z")}}));
  const auto ned = read(local(file.path(), {{"north", metres("y")}, {"east", metres("x")}, {"down", metres("down")}}));
  REQUIRE(enu.size() == 2);
  CHECK(enu[0].fields == ned[0].fields);
  CHECK(std::abs(enu[1].fields[0] - 49.01 * degree) < 1e-15);
  CHECK(std::abs(enu[1].fields[1] - 8.43 * degree) < 1e-15);
  CHECK(std::abs(enu[1].fields[2] - 115) < 1e-8);

  // The way from the origin, turned to its axes by two rotations: about z by the longitude, about east by the latitude.
  const auto& lla = enu[0].fields;
  const Vector3d way = ecef(lla[0], lla[1], lla[2]) - ecef(49.01 * degree, 8.43 * degree, 115);
  const Vector3d up_east_north = Eigen::AngleAxisd(49.01 * degree, Vector3d::UnitY()) *
                                 (Eigen::AngleAxisd(-8.43 * degree, Vector3d::UnitZ()) * way);
  CHECK((up_east_north - Vector3d{56, 1200, -3400}).norm() < 1e-7);
}

TEST_CASE("csv turns local velocities, scales and shifts columns before", "[csv]") {
  const TemporaryFile file("t,x,y,z,vx,vy,vz\n0,1.2,-3.4,5600,5,6,1\n1,,0,0,1,1,1\n2,0,0,0,5,6,1\n");
  auto x = metres("x", 1000);
  x["missing"] = Json::array({""});
  auto z = metres("z", 0.01);
  z["scale"] = -1;
  z["offset"] = quantity(3, "m");
  const auto samples = read(local(file.path(), {{"north", metres("y", 1000)},
                                                {"east", x},
                                                {"down", z},
                                                {"v_north", speed("vy")},
                                                {"v_east", speed("vx")},
                                                {"v_up", speed("vz")}}));
  REQUIRE(samples.size() == 3);
  REQUIRE(samples[0].fields.size() == 6);
  CHECK(samples[0].fields[2] == Approx(115 + 53 + (1200.0 * 1200 + 3400.0 * 3400) / (2 * 6.378e6)).margin(0.02));
  CHECK(samples[0].fields[3] == Approx(6).margin(0.01));
  CHECK(samples[0].fields[4] == Approx(5).margin(0.01));
  CHECK(samples[0].fields[5] == Approx(-1 + (5 * 1200.0 - 6 * 3400.0) / -6.378e6).margin(1e-4));
  CHECK(samples[2].fields[3] == Approx(6).margin(1e-12));
  CHECK(samples[2].fields[4] == Approx(5).margin(1e-12));
  CHECK(samples[2].fields[5] == Approx(-1).margin(1e-12));
  for (const double missing : samples[1].fields) CHECK(std::isnan(missing));
}

TEST_CASE("csv says what is wrong with local columns", "[csv]") {
  const TemporaryFile file("t,x,y,z,v\n0,1,2,3,4\n1,1,2e9,3,4\n");
  const auto said = [&](Members members) { return fault_of(local(file.path(), std::move(members))); };
  const auto x = metres("x"), y = metres("y"), z = metres("z");
  CHECK(said({{"north", y}, {"east", x}, {"down", z}}) ==
        "B062 line 3: the local position is more than 10 000 km from the origin");
  CHECK(said({{"nord", y}, {"east", x}, {"up", z}}) ==
        "/local/nord: 'nord' is not a local axis; did you mean 'north'?");
  CHECK_THAT(said({{"x", y}, {"east", x}, {"up", z}}),
             Contains("/local/x: 'x' is not a local axis; they are: north, east"));
  CHECK(said({{"north", y}, {"east", x}}) == "/local: 'down' or 'up' is missing: local axes are three");
  CHECK(said({{"east", x}, {"up", z}}) == "/local: 'north' is missing: local axes are three");
  CHECK(said({{"north", y}, {"east", x}, {"down", z}, {"up", z}}) == "/local/up: 'down' and 'up' are the same axis");
  CHECK(said({{"north", y}, {"east", x}, {"up", z}, {"v_up", speed("v")}}) ==
        "/local: 'v_north' is missing: local axes are three");
  CHECK(said({{"north", y}, {"east", speed("x")}, {"up", z}}) ==
        "/local/east/unit: 'east' is in m; found the unit m/s");
  CHECK_THAT(said({{"north", metres("yy")}, {"east", x}, {"up", z}}), Contains("/local/north/column: no column 'yy'"));
  auto shifted = metres("x");
  shifted["offset"] = quantity(3, "rad");
  CHECK(said({{"north", y}, {"east", shifted}, {"up", z}}) ==
        "/local/east/offset: 'offset' has the unit rad, and the column is in m");
  auto nothing = metres("x");
  nothing["scale"] = 0;
  CHECK_THAT(said({{"north", y}, {"east", nothing}, {"up", z}}), Contains("/local/east/scale: 'scale' is 0"));

  const auto without =
      with_member(parameters(file.path(), {}), "local", object({{"north", y}, {"east", x}, {"up", z}}));
  CHECK_THAT(fault_of(without), Contains("/local: local columns need an origin") && Contains("here or at the top") &&
                                    Contains("(/origin)"));
  const auto twice = with_member(with_member(parameters(file.path(), {{"lat", column("v", unit("rad"))}}), "local",
                                             object({{"north", y}, {"east", x}, {"up", z}})),
                                 "origin", origin());
  CHECK(fault_of(twice) == "/local: 'lat' is in 'columns' too, but 'local' computes it");
}

}  // namespace csv_local_test
