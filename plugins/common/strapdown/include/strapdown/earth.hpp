// SPDX-License-Identifier: Apache-2.0
// The WGS-84 earth: ellipsoid, rotation, normal gravity, geodetic and Cartesian positions.
#pragma once

#include <Eigen/Core>

namespace binnacle::strapdown {

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
Radii radii(double lat);
/// The same when the sine and cosine of the latitude are at hand.
Radii radii(double sin_lat, double cos_lat);

/// Earth rate in navigation axes, rad/s: Ω (cos L, 0, −sin L).
Eigen::Vector3d omega_ie_n(double lat);

/// Transport rate in navigation axes, rad/s: (v_E/(R_t+h), −v_N/(R_m+h), −v_E tan L/(R_t+h)).
Eigen::Vector3d omega_en_n(double lat, double height, const Eigen::Vector3d& v_n);

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
Gravity gravity(double lat, double height);
/// The same when the sine and cosine of the latitude are at hand.
Gravity gravity(double sin_lat, double cos_lat, double height);

/// Position ⊞: d_ned (m) north, east, down, by the radii at `lla`:
///   L + d_N/(R_m+h),  l + d_E/((R_t+h) cos L),  h − d_D;  longitude is wrapped to [−pi, pi].
/// A chart, not a geodesic. Latitude is not reflected at a pole; within a few d_ned of one use another chart.
Eigen::Vector3d position_plus(const Eigen::Vector3d& lla, const Eigen::Vector3d& d_ned);

/// Position ⊟, the exact inverse: position_minus(position_plus(x, d), x) == d to roundoff (some nm), by the radii at
/// `from`; the longitude difference is taken the short way round.
Eigen::Vector3d position_minus(const Eigen::Vector3d& lla, const Eigen::Vector3d& from);

/// Geodetic to earth-centred, earth-fixed Cartesian (m), and back. The inverse holds to nanometres for heights above
/// −5000 km, poles and equator included; longitude at a pole is zero.
Eigen::Vector3d ecef_from_lla(const Eigen::Vector3d& lla);
Eigen::Vector3d lla_from_ecef(const Eigen::Vector3d& r_e);

/// C_en: navigation to earth components; its columns are north, east, down in ECEF.
Eigen::Matrix3d C_en(double lat, double lon);

}  // namespace binnacle::strapdown
