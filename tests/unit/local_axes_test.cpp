// SPDX-License-Identifier: Apache-2.0
// geodesy::LocalAxes: signs of its axes, against GeographicLib's local Cartesian coordinates, and back.
#include "binnacle/local_axes.hpp"

#include <cmath>
#include <numbers>

#include <GeographicLib/LocalCartesian.hpp>

#include "catch.hpp"

namespace local_axes_test {

using namespace binnacle::geodesy;
using Eigen::Vector3d;

namespace {

constexpr double degree = std::numbers::pi / 180.0;
const Vector3d karlsruhe{49.01 * degree, 8.43 * degree, 115.0};

}  // namespace

TEST_CASE("local axes point north, east and down, and east-north-up has its signs", "[geodesy]") {
  const LocalAxes axes(karlsruhe);
  REQUIRE(axes.ned_from_lla(karlsruhe).norm() < 1e-8);
  const Vector3d north = axes.ned_from_lla(karlsruhe + Vector3d{1e-5, 0, 0});
  const Vector3d east = axes.ned_from_lla(karlsruhe + Vector3d{0, 1e-5, 0});
  const Vector3d higher = axes.ned_from_lla(karlsruhe + Vector3d{0, 0, 7});
  REQUIRE(north[0] > 63.0);
  REQUIRE(std::abs(north[1]) < 1e-8);
  REQUIRE(east[1] > 41.0);
  REQUIRE(east[1] < 42.0);
  REQUIRE((higher - Vector3d{0, 0, -7}).norm() < 1e-8);
  REQUIRE(enu_from_ned(Vector3d{1, 2, 3}) == Vector3d{2, 1, -3});
  REQUIRE(enu_from_ned(Vector3d{2, 1, -3}) == Vector3d{1, 2, 3});
}

TEST_CASE("local coordinates are GeographicLib's LocalCartesian, and go back", "[geodesy]") {
  for (const Vector3d& origin : {karlsruhe, Vector3d{-33.9 * degree, 179.99 * degree, -20}, Vector3d{0, 0, 0},
                                 Vector3d{89.9 * degree, -120 * degree, 3000}}) {
    const LocalAxes axes(origin);
    const GeographicLib::LocalCartesian oracle(origin[0] / degree, origin[1] / degree, origin[2]);
    for (const Vector3d& p : {Vector3d{100, -20, 3}, Vector3d{-3000, 12000, -800}, Vector3d{250000, 100000, 5000}}) {
      double lat = 0, lon = 0, height = 0;
      oracle.Reverse(p[1], p[0], -p[2], lat, lon, height);  // east, north, up
      const Vector3d lla = axes.lla_from_ned(p);
      CHECK(std::abs(lla[0] - lat * degree) * 6.4e6 < 1e-7);
      CHECK(std::abs(std::remainder(lla[1] - lon * degree, 2 * std::numbers::pi)) * 6.4e6 * std::cos(lla[0]) < 1e-7);
      CHECK(std::abs(lla[2] - height) < 1e-7);
      CHECK((axes.ned_from_lla(lla) - p).norm() < 1e-7);
    }
  }
}

TEST_CASE("a velocity along local axes is turned to those of its place", "[geodesy]") {
  const LocalAxes axes(karlsruhe);
  const Vector3d p{20000, 30000, -100}, v{3, -7, 0.5};
  const double h = 0.01;
  const Vector3d lla = axes.lla_from_ned(p);
  // Where it leads, as seen at the place: position_minus has north, east, down of its second argument.
  const Vector3d way = position_minus(axes.lla_from_ned(p + h * v), axes.lla_from_ned(p - h * v)) / (2 * h);
  CHECK((axes.C_nl(lla) * v - way).norm() < 1e-5);
  CHECK((v - way).norm() > 0.02);  // 30 km over the earth's radius of 7.6 m/s
}

}  // namespace local_axes_test
