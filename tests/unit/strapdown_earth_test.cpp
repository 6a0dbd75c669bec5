// SPDX-License-Identifier: Apache-2.0
// strapdown/earth.hpp against GeographicLib and finite differences.
#include "catch.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/NormalGravity.hpp>

#include "strapdown/earth.hpp"

namespace strapdown_earth_test {

using namespace binnacle::strapdown;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double degree = std::numbers::pi / 180.0;
const std::vector<double> latitudes = {-89.99, -75.0, -45.0, -10.0, 0.0, 1e-9, 20.0, 37.0, 60.0, 75.0, 89.0};

}  // namespace

TEST_CASE("the constants of WGS-84 are those of GeographicLib", "[strapdown][earth]") {
  const auto& oracle = GeographicLib::NormalGravity::WGS84();
  REQUIRE(wgs84::a == oracle.EquatorialRadius());
  REQUIRE(std::abs(wgs84::f - oracle.Flattening()) < 1e-17);
  REQUIRE(std::abs(wgs84::gm - oracle.MassConstant()) < 1e6);
  REQUIRE(std::abs(wgs84::omega_ie - oracle.AngularVelocity()) < 1e-16);
  REQUIRE(std::abs(wgs84::gamma_e - oracle.EquatorialGravity()) < 1e-10);
  REQUIRE(std::abs(wgs84::gamma_p - oracle.PolarGravity()) < 1e-10);
  REQUIRE(std::abs(wgs84::k - 0.00193185265241) < 3e-11);  // TR8350.2, table 3.4; 3e-11 is gamma_p's last digit
  REQUIRE(std::abs(wgs84::m - 0.00344978650684) < 1e-13);
}

TEST_CASE("Cartesian positions and axes agree with GeographicLib", "[strapdown][earth]") {
  const GeographicLib::Geocentric& oracle = GeographicLib::Geocentric::WGS84();
  for (double lat : latitudes) {
    for (double lon : {-180.0, -127.3, 0.0, 45.0, 127.0, 179.9}) {
      for (double height : {-5000.0, 0.0, 100.0, 12000.0, 2.0e7}) {
        double x = 0, y = 0, z = 0;
        std::vector<double> m(9);
        oracle.Forward(lat, lon, height, x, y, z, m);
        const Vector3d lla{lat * degree, lon * degree, height};
        const Vector3d r = ecef_from_lla(lla);
        REQUIRE((r - Vector3d{x, y, z}).norm() < 1e-8);

        // GeographicLib's matrix has east, north, up as columns, row major.
        Matrix3d expected;
        expected << m[1], m[0], -m[2], m[4], m[3], -m[5], m[7], m[6], -m[8];
        REQUIRE((C_en(lla[0], lla[1]) - expected).norm() < 1e-14);

        const Vector3d back = lla_from_ecef(r);
        REQUIRE(std::abs(back[0] - lla[0]) * 6.4e6 < 1e-8);
        REQUIRE(std::abs(std::remainder(back[1] - lla[1], 2 * std::numbers::pi)) * 6.4e6 * std::cos(lla[0]) < 1e-8);
        REQUIRE(std::abs(back[2] - lla[2]) < 2e-8);
      }
    }
  }
  REQUIRE((lla_from_ecef({0, 0, wgs84::b + 10}) - Vector3d{90 * degree, 0, 10}).norm() < 1e-8);
  REQUIRE((lla_from_ecef({0, 0, -wgs84::b - 10}) - Vector3d{-90 * degree, 0, 10}).norm() < 1e-8);
}

TEST_CASE("radii of curvature are those of the ellipsoid", "[strapdown][earth]") {
  for (double lat : {-75.0, -20.0, 0.0, 37.0, 80.0}) {
    const double l = lat * degree, step = 1e-4;
    const Radii r = radii(l);
    // Arc length along the meridian and along the parallel, from the Cartesian position.
    const Vector3d north = (ecef_from_lla({l + step, 0.3, 0}) - ecef_from_lla({l - step, 0.3, 0})) / (2 * step);
    const Vector3d east = (ecef_from_lla({l, 0.3 + step, 0}) - ecef_from_lla({l, 0.3 - step, 0})) / (2 * step);
    REQUIRE(std::abs(north.norm() - r.meridian) < 0.05);
    REQUIRE(std::abs(east.norm() - r.transverse * std::cos(l)) < 0.05);
    REQUIRE(std::abs((radii(l + step).meridian - radii(l - step).meridian) / (2 * step) - r.d_meridian) < 1e-2);
    REQUIRE(std::abs((radii(l + step).transverse - radii(l - step).transverse) / (2 * step) - r.d_transverse) < 1e-2);
  }
  REQUIRE(std::abs(radii(45 * degree).meridian - 6367381.816) < 1e-2);
  REQUIRE(std::abs(radii(45 * degree).transverse - 6388838.290) < 1e-2);
}

TEST_CASE("earth rate and transport rate are turns of the navigation axes", "[strapdown][earth]") {
  for (double lat : {-75.0, -30.0, 0.0, 37.0, 75.0}) {
    const double l = lat * degree, lon = 2.1, height = 5000.0;
    const Matrix3d c = C_en(l, lon);
    REQUIRE((c * omega_ie_n(l) - Vector3d{0, 0, wgs84::omega_ie}).norm() < 1e-19);

    // dC_en/dt = C_en [ω_en×] along the motion that the velocity makes.
    const Vector3d v{250.0, -130.0, 7.0};
    const double step = 0.5;
    const Radii r = radii(l);
    const double lat_rate = v[0] / (r.meridian + height), lon_rate = v[1] / ((r.transverse + height) * std::cos(l));
    const Matrix3d rate =
        c.transpose() *
        (C_en(l + step * lat_rate, lon + step * lon_rate) - C_en(l - step * lat_rate, lon - step * lon_rate)) /
        (2 * step);
    const Vector3d omega = omega_en_n(l, height, v);
    REQUIRE((Vector3d{rate(2, 1), rate(0, 2), rate(1, 0)} - omega).norm() < 1e-12);
  }
}

TEST_CASE("normal gravity agrees with GeographicLib", "[strapdown][earth]") {
  const auto& oracle = GeographicLib::NormalGravity::WGS84();
  for (double lat : latitudes) {
    REQUIRE(std::abs(gravity(lat * degree, 0.0).down - oracle.SurfaceGravity(lat)) < 1e-9);
    for (double height : {-500.0, 100.0, 3000.0, 10000.0, 20000.0}) {
      double north = 0, up = 0;
      oracle.Gravity(lat, height, north, up);
      CAPTURE(lat, height);
      REQUIRE(std::abs(gravity(lat * degree, height).down + up) < 2e-6);
      // What is left out on purpose.
      REQUIRE(std::abs(north + 8.1e-9 * height * std::sin(2 * lat * degree)) < 2e-6);
    }
  }
}

TEST_CASE("gravity's partials against differences", "[strapdown][earth]") {
  for (double lat : latitudes) {
    for (double height : {-500.0, 0.0, 3000.0, 15000.0}) {
      const double l = lat * degree;
      const Gravity g = gravity(l, height);
      const double by_lat = (gravity(l + 1e-4, height).down - gravity(l - 1e-4, height).down) / 2e-4;
      const double by_height = (gravity(l, height + 100.0).down - gravity(l, height - 100.0).down) / 200.0;
      REQUIRE(std::abs(g.d_lat - by_lat) < 1e-9);
      REQUIRE(std::abs(g.d_height - by_height) < 1e-14);
      REQUIRE(g.d_height < -3.0e-6);
    }
  }
  REQUIRE(gravity(0.7, 0.0).d_lat > 0.05);
  REQUIRE(gravity(-0.7, 0.0).d_lat < -0.05);
}

TEST_CASE("position plus and minus are inverse and in metres", "[strapdown][earth]") {
  for (double lat : {-89.9, -75.0, 0.0, 37.0, 75.0, 89.9}) {
    for (double lon : {-180.0, -179.9999, 0.0, 127.0, 179.9999, 180.0}) {
      for (const Vector3d& d :
           {Vector3d{0, 0, 0}, Vector3d{3, -4, 5}, Vector3d{-20, 60, -1}, Vector3d{900, 5000, 300}}) {
        const Vector3d x{lat * degree, lon * degree, 120.0};
        const Vector3d moved = position_plus(x, d);
        CAPTURE(lat, lon, d.transpose());
        REQUIRE((position_minus(moved, x) - d).norm() < 1e-8);
        REQUIRE(std::abs(moved[1]) <= std::numbers::pi);
      }
      const Vector3d x{lat * degree, lon * degree, 120.0};
      const Vector3d d{0.3, -0.4, 0.5};
      const Vector3d true_ned = C_en(x[0], x[1]).transpose() * (ecef_from_lla(position_plus(x, d)) - ecef_from_lla(x));
      REQUIRE((true_ned - d).norm() < 2e-5);
    }
  }
}

}  // namespace strapdown_earth_test
