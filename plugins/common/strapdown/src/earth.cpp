// SPDX-License-Identifier: Apache-2.0
// The WGS-84 earth.
#include "strapdown/earth.hpp"

#include <cmath>
#include <numbers>

#include "ellipsoid.hpp"

namespace binnacle::strapdown {

namespace {

double wrapped(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

}  // namespace

Radii radii(double lat) { return radii(std::sin(lat), std::cos(lat)); }

Radii radii(double sin_lat, double cos_lat) { return detail::radii(sin_lat, cos_lat, detail::inverse_w(sin_lat)); }

Eigen::Vector3d omega_ie_n(double lat) {
  return {wgs84::omega_ie * std::cos(lat), 0.0, -wgs84::omega_ie * std::sin(lat)};
}

Eigen::Vector3d omega_en_n(double lat, double height, const Eigen::Vector3d& v_n) {
  const Radii r = radii(lat);
  const double east_rate = v_n[1] / (r.transverse + height);
  return {east_rate, -v_n[0] / (r.meridian + height), -east_rate * std::tan(lat)};
}

Gravity gravity(double lat, double height) { return gravity(std::sin(lat), std::cos(lat), height); }

Gravity gravity(double sin_lat, double cos_lat, double height) {
  return detail::gravity(sin_lat, cos_lat, detail::inverse_w(sin_lat), height);
}

Eigen::Vector3d position_plus(const Eigen::Vector3d& lla, const Eigen::Vector3d& d_ned) {
  const double cos_lat = std::cos(lla[0]);
  const Radii r = radii(std::sin(lla[0]), cos_lat);
  return {lla[0] + d_ned[0] / (r.meridian + lla[2]), wrapped(lla[1] + d_ned[1] / ((r.transverse + lla[2]) * cos_lat)),
          lla[2] - d_ned[2]};
}

Eigen::Vector3d position_minus(const Eigen::Vector3d& lla, const Eigen::Vector3d& from) {
  const double cos_lat = std::cos(from[0]);
  const Radii r = radii(std::sin(from[0]), cos_lat);
  return {(lla[0] - from[0]) * (r.meridian + from[2]), wrapped(lla[1] - from[1]) * ((r.transverse + from[2]) * cos_lat),
          from[2] - lla[2]};
}

Eigen::Vector3d ecef_from_lla(const Eigen::Vector3d& lla) {
  const double s = std::sin(lla[0]), c = std::cos(lla[0]);
  const double r_t = radii(s, c).transverse;
  const double equatorial = (r_t + lla[2]) * c;
  return {equatorial * std::cos(lla[1]), equatorial * std::sin(lla[1]), (r_t * (1.0 - wgs84::e2) + lla[2]) * s};
}

Eigen::Vector3d lla_from_ecef(const Eigen::Vector3d& r_e) {
  using wgs84::a, wgs84::b, wgs84::e2, wgs84::f;
  constexpr double second_e2 = e2 / (1.0 - e2);
  constexpr int iterations = 3;  // each gains a factor of about e⁴; two would do for heights that ships and cars have
  const double p = std::hypot(r_e[0], r_e[1]);
  const double z = r_e[2];
  // Bowring (1976): tan L = (z + e'² b sin³β)/(p − e² a cos³β) with tan β = (1−f) tan L, started at tan β = z a/(p b).
  Eigen::Vector2d beta = Eigen::Vector2d{p * b, z * a}.normalized();  // (cos, sin) of the parametric latitude
  Eigen::Vector2d lat;                                                // (cos, sin) of the geodetic latitude
  for (int i = 0; i < iterations; ++i) {
    lat = Eigen::Vector2d{p - e2 * a * beta[0] * beta[0] * beta[0], z + second_e2 * b * beta[1] * beta[1] * beta[1]}
              .normalized();
    beta = Eigen::Vector2d{lat[0], (1.0 - f) * lat[1]}.normalized();
  }
  const double height = p * lat[0] + z * lat[1] - a * std::sqrt(1.0 - e2 * lat[1] * lat[1]);
  return {std::atan2(lat[1], lat[0]), std::atan2(r_e[1], r_e[0]), height};
}

Eigen::Matrix3d C_en(double lat, double lon) {
  const double sl = std::sin(lat), cl = std::cos(lat);
  const double so = std::sin(lon), co = std::cos(lon);
  Eigen::Matrix3d c;
  c << -sl * co, -so, -cl * co, -sl * so, co, -cl * so, cl, 0.0, -sl;
  return c;
}

}  // namespace binnacle::strapdown
