// SPDX-License-Identifier: Apache-2.0
// The WGS-84 earth: ellipsoid, rotation, normal gravity, geodetic and Cartesian positions. Header-only.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <numbers>

namespace binnacle::geodesy {

// A position `lla` is (latitude rad, longitude rad, height m) on the WGS-84 ellipsoid, an Eigen::Vector3d.
// Navigation axes are north, east, down. Constants: NIMA TR8350.2, 3rd edition, tables 3.1 to 3.4.
namespace wgs84 {
inline constexpr double a = 6378137.0;                             ///< m, semi-major axis
inline constexpr double f = 1.0 / 298.257223563;                   ///< flattening
inline constexpr double e2 = f * (2.0 - f);                        ///< first eccentricity squared
inline constexpr double b = a * (1.0 - f);                         ///< m, semi-minor axis
inline constexpr double gm = 3.986004418e14;                       ///< m³/s², atmosphere included
inline constexpr double omega_ie = 7.292115e-5;                    ///< rad/s
inline constexpr double gamma_e = 9.7803253359;                    ///< m/s², normal gravity at the equator
inline constexpr double gamma_p = 9.8321849378;                    ///< m/s², normal gravity at the poles
inline constexpr double k = b * gamma_p / (a * gamma_e) - 1.0;     ///< Somigliana's constant
inline constexpr double m = omega_ie * omega_ie * a * a * b / gm;  ///< centrifugal to gravity at the equator
}  // namespace wgs84

/// Radii of curvature (m) and their derivatives by latitude (m/rad). R_m: meridian; R_t: transverse (prime vertical).
struct Radii {
  double meridian;
  double transverse;
  double d_meridian;
  double d_transverse;
};

/// 1/√(1 − e² sin²L), what radii and gravity share.
inline double inverse_w(double sin_lat) { return 1.0 / std::sqrt(1.0 - wgs84::e2 * sin_lat * sin_lat); }

/// From what is at hand of the latitude.
inline Radii radii(double sin_lat, double cos_lat, double inverse_w) {
  using namespace wgs84;
  const double inverse_w2 = inverse_w * inverse_w;
  const double transverse = a * inverse_w;
  const double meridian = (1.0 - e2) * transverse * inverse_w2;
  const double slope = e2 * sin_lat * cos_lat * inverse_w2;
  return {meridian, transverse, 3.0 * meridian * slope, transverse * slope};
}
inline Radii radii(double sin_lat, double cos_lat) { return radii(sin_lat, cos_lat, inverse_w(sin_lat)); }
inline Radii radii(double lat) { return radii(std::sin(lat), std::cos(lat)); }

/// Earth rate in navigation axes, rad/s: Ω (cos L, 0, −sin L).
inline Eigen::Vector3d omega_ie_n(double lat) {
  return {wgs84::omega_ie * std::cos(lat), 0.0, -wgs84::omega_ie * std::sin(lat)};
}

/// Transport rate in navigation axes, rad/s: (v_E/(R_t+h), −v_N/(R_m+h), −v_E tan L/(R_t+h)).
inline Eigen::Vector3d omega_en_n(double lat, double height, const Eigen::Vector3d& v_n) {
  const Radii r = radii(lat);
  const double east_rate = v_n[1] / (r.transverse + height);
  return {east_rate, -v_n[0] / (r.meridian + height), -east_rate * std::tan(lat)};
}

/// Normal gravity along down and its exact partial derivatives.
///   γ₀ = γ_e (1 + k sin²L) / √(1 − e² sin²L)                                        (Somigliana, TR8350.2 (4-1))
///   γ  = γ₀ [1 − (2/a)(1 + f + m − 2 f sin²L) h + (3/a²) h²]                         (TR8350.2 (4-3))
/// Taken along the ellipsoid's normal: the north component that grows with height (about −8.1e-9 h sin 2L m/s²,
/// 8 µg at 10 km) is not modelled. Against the closed form the series is good to 2e-6 m/s² up to 20 km.
struct Gravity {
  double down;      ///< m/s²
  double d_lat;     ///< m/s²/rad
  double d_height;  ///< m/s²/m
};
/// From what is at hand of the latitude.
inline Gravity gravity(double sin_lat, double cos_lat, double inverse_w, double height) {
  using namespace wgs84;
  const double s2 = sin_lat * sin_lat, sc = sin_lat * cos_lat;
  const double somigliana = 1.0 + k * s2;
  const double surface = gamma_e * somigliana * inverse_w;
  const double surface_lat = gamma_e * inverse_w * sc * (2.0 * k + somigliana * e2 * inverse_w * inverse_w);
  const double slope = (2.0 / a) * (1.0 + f + m - 2.0 * f * s2);
  const double slope_lat = -(8.0 / a) * f * sc;
  const double factor = 1.0 + height * (-slope + (3.0 / (a * a)) * height);
  return {surface * factor, surface_lat * factor - surface * slope_lat * height,
          surface * (-slope + (6.0 / (a * a)) * height)};
}
inline Gravity gravity(double sin_lat, double cos_lat, double height) {
  return gravity(sin_lat, cos_lat, inverse_w(sin_lat), height);
}
inline Gravity gravity(double lat, double height) { return gravity(std::sin(lat), std::cos(lat), height); }

/// The same longitude in [−π, π].
inline double wrapped_longitude(double angle) { return std::remainder(angle, 2.0 * std::numbers::pi); }

/// Position ⊞: d_ned (m) north, east, down, by the radii at `lla`:
///   L + d_N/(R_m+h),  l + d_E/((R_t+h) cos L),  h − d_D;  longitude is wrapped to [−pi, pi].
/// A chart, not a geodesic. Latitude is not reflected at a pole; within a few d_ned of one use another chart.
inline Eigen::Vector3d position_plus(const Eigen::Vector3d& lla, const Eigen::Vector3d& d_ned) {
  const double cos_lat = std::cos(lla[0]);
  const Radii r = radii(std::sin(lla[0]), cos_lat);
  return {lla[0] + d_ned[0] / (r.meridian + lla[2]),
          wrapped_longitude(lla[1] + d_ned[1] / ((r.transverse + lla[2]) * cos_lat)), lla[2] - d_ned[2]};
}

/// ∂ position_plus(lla, d_ned)/∂ d_ned, a diagonal that does not depend on d_ned: rad/m, rad/m, −1.
inline Eigen::Vector3d position_plus_jacobian(const Eigen::Vector3d& lla) {
  const double cos_lat = std::cos(lla[0]);
  const Radii r = radii(std::sin(lla[0]), cos_lat);
  return {1.0 / (r.meridian + lla[2]), 1.0 / ((r.transverse + lla[2]) * cos_lat), -1.0};
}

/// Position ⊟, the exact inverse: position_minus(position_plus(x, d), x) == d to roundoff (some nm), by the radii at
/// `from`; the longitude difference is taken the short way round.
inline Eigen::Vector3d position_minus(const Eigen::Vector3d& lla, const Eigen::Vector3d& from) {
  const double cos_lat = std::cos(from[0]);
  const Radii r = radii(std::sin(from[0]), cos_lat);
  return {(lla[0] - from[0]) * (r.meridian + from[2]),
          wrapped_longitude(lla[1] - from[1]) * ((r.transverse + from[2]) * cos_lat), from[2] - lla[2]};
}

/// Geodetic to earth-centred, earth-fixed Cartesian (m), and back. The inverse holds to nanometres for heights above
/// −5000 km, poles and equator included; longitude at a pole is zero.
inline Eigen::Vector3d ecef_from_lla(const Eigen::Vector3d& lla) {
  const double s = std::sin(lla[0]), c = std::cos(lla[0]);
  const double r_t = radii(s, c).transverse;
  const double equatorial = (r_t + lla[2]) * c;
  return {equatorial * std::cos(lla[1]), equatorial * std::sin(lla[1]), (r_t * (1.0 - wgs84::e2) + lla[2]) * s};
}
inline Eigen::Vector3d lla_from_ecef(const Eigen::Vector3d& r_e) {
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

/// C_en: navigation to earth components; its columns are north, east, down in ECEF.
inline Eigen::Matrix3d C_en(double lat, double lon) {
  const double sl = std::sin(lat), cl = std::cos(lat);
  const double so = std::sin(lon), co = std::cos(lon);
  Eigen::Matrix3d c;
  c << -sl * co, -so, -cl * co, -sl * so, co, -cl * so, cl, 0.0, -sl;
  return c;
}

}  // namespace binnacle::geodesy
