// SPDX-License-Identifier: Apache-2.0
// Broadcast orbit and clock of a satellite.
#include "gnss/orbit.hpp"

#include <cmath>

#include "gnss/gps_time.hpp"

namespace binnacle::gnss {

namespace {

/// μ as the constellation's users are to take it: IS-GPS-200 table 20-IV, Galileo OS SIS ICD table 58, BDS-SIS-ICD-B1I-3.0
/// table 5-11 [m³/s²].
double gravitational_constant(SatelliteKey key) {
  return constellation_of(key) == Constellation::gps ? 3.986005e14 : 3.986004418e14;
}

constexpr double omega_e_beidou = 7.2921150e-5;  // rad/s, the same table

bool is_geostationary(SatelliteKey key) {
  const SatelliteKey number = key % 100;
  return constellation_of(key) == Constellation::beidou && (number <= 5 || number >= 59);
}

/// A geostationary orbit's elements are of axes that were tilted by 5 deg about x, so that its inclination is none of zero:
/// r = R_z(ω t) R_x(−5°) r_tilted, and the tilted axes do not turn.
void untilt(SatelliteState& state, double tk) {
  constexpr double tilt = 5 * M_PI / 180;
  const double s = std::sin(omega_e_beidou * tk), c = std::cos(omega_e_beidou * tk);
  const auto turned = [&](const Eigen::Vector3d& v) {
    const double y = v.y() * std::cos(tilt) - v.z() * std::sin(tilt);
    return Eigen::Vector3d(c * v.x() + s * y, c * y - s * v.x(), v.y() * std::sin(tilt) + v.z() * std::cos(tilt));
  };
  state.position = turned(state.position);
  state.velocity =
      turned(state.velocity) + omega_e_beidou * Eigen::Vector3d(state.position.y(), -state.position.x(), 0);
}

double since(double reference, Time t, double back) { return seconds(t - nanoseconds(reference)) - back; }

struct Anomaly {
  double E;
  double E_dot;
};

Anomaly anomaly_at(const Ephemeris& e, double mu, double tk) {
  const double n = std::sqrt(mu / (e.semi_major_axis * e.semi_major_axis * e.semi_major_axis)) + e.delta_n;
  const double E = eccentric_anomaly(e.m0 + n * tk, e.eccentricity);
  return {E, n / (1 - e.eccentricity * std::cos(E))};
}

/// F e √A = −2 √(μ A) e / c².
double relativity(const Ephemeris& e, double mu) {
  return -2 * std::sqrt(mu * e.semi_major_axis) * e.eccentricity / (speed_of_light * speed_of_light);
}

}  // namespace

double eccentric_anomaly(double mean_anomaly, double eccentricity) {
  const double M = std::remainder(mean_anomaly, 2 * M_PI);
  // π, or M + e for a nearly circular orbit, starts on the side from which Newton's steps are monotonic.
  double E = eccentricity < 0.3 ? M + eccentricity * std::sin(M) : std::copysign(M_PI, M);
  for (int i = 0; i < 50; ++i) {
    const double step = (E - eccentricity * std::sin(E) - M) / (1 - eccentricity * std::cos(E));
    E -= step;
    if (std::abs(step) < 1e-14) break;
  }
  return E;
}

double satellite_clock(const Ephemeris& e, Time t, double back) {
  const double mu = gravitational_constant(e.satellite);
  const double dt = since(e.toc, t, back);
  return e.af0 + dt * (e.af1 + dt * e.af2) + relativity(e, mu) * std::sin(anomaly_at(e, mu, since(e.toe, t, back)).E);
}

SatelliteState satellite_state(const Ephemeris& e, Time t, double back) {
  const double mu = gravitational_constant(e.satellite);
  const double tk = since(e.toe, t, back);
  const auto [E, E_dot] = anomaly_at(e, mu, tk);
  const double sin_E = std::sin(E), cos_E = std::cos(E);
  const double root = std::sqrt(1 - e.eccentricity * e.eccentricity);
  const double near = 1 - e.eccentricity * cos_E;
  const double phi = std::atan2(root * sin_E, cos_E - e.eccentricity) + e.perigee;
  const double phi_dot = E_dot * root / near;

  const double sin_2 = std::sin(2 * phi), cos_2 = std::cos(2 * phi);
  const double u = phi + e.cus * sin_2 + e.cuc * cos_2;
  const double u_dot = phi_dot * (1 + 2 * (e.cus * cos_2 - e.cuc * sin_2));
  const double r = e.semi_major_axis * near + e.crs * sin_2 + e.crc * cos_2;
  const double r_dot =
      e.semi_major_axis * e.eccentricity * sin_E * E_dot + 2 * phi_dot * (e.crs * cos_2 - e.crc * sin_2);
  const double i = e.i0 + e.i_dot * tk + e.cis * sin_2 + e.cic * cos_2;
  const double i_dot = e.i_dot + 2 * phi_dot * (e.cis * cos_2 - e.cic * sin_2);

  const double x = r * std::cos(u), y = r * std::sin(u);  // in the orbital plane
  const double x_dot = r_dot * std::cos(u) - y * u_dot, y_dot = r_dot * std::sin(u) + x * u_dot;
  const bool is_beidou = constellation_of(e.satellite) == Constellation::beidou,
             is_tilted = is_geostationary(e.satellite);
  const double omega = is_beidou ? omega_e_beidou : omega_e;
  const double node_dot = is_tilted ? e.omega_dot : e.omega_dot - omega;
  const double node = e.omega0 + node_dot * tk - omega * time_of_week(is_beidou ? e.toe - gps_minus_beidou : e.toe);
  const double sin_node = std::sin(node), cos_node = std::cos(node);
  const double sin_i = std::sin(i), cos_i = std::cos(i);

  SatelliteState state;
  state.position = {x * cos_node - y * cos_i * sin_node, x * sin_node + y * cos_i * cos_node, y * sin_i};
  const double across_dot = y_dot * cos_i - y * sin_i * i_dot;  // of y cos i
  state.velocity = {x_dot * cos_node - across_dot * sin_node - state.position.y() * node_dot,
                    x_dot * sin_node + across_dot * cos_node + state.position.x() * node_dot,
                    y_dot * sin_i + y * cos_i * i_dot};
  if (is_tilted) untilt(state, tk);
  const double dt = since(e.toc, t, back);
  const double F = relativity(e, mu);
  state.clock = e.af0 + dt * (e.af1 + dt * e.af2) + F * sin_E;
  state.clock_drift = e.af1 + 2 * e.af2 * dt + F * cos_E * E_dot;
  return state;
}

bool is_usable(const Ephemeris& e) {
  const double sum = e.toe + e.toc + e.i0 + e.omega0 + e.perigee + e.m0 + e.delta_n + e.omega_dot + e.i_dot + e.cuc +
                     e.cus + e.crc + e.crs + e.cic + e.cis + e.af0 + e.af1 + e.af2;
  const double longest = 4e9;  // s: a time that fits nanoseconds in 64 bits, with room
  return e.satellite != 0 && std::isfinite(sum) && std::abs(e.toe) < longest && std::abs(e.toc) < longest &&
         e.semi_major_axis > 1e7 && e.semi_major_axis < 1e8 && e.eccentricity >= 0 && e.eccentricity < 0.5 &&
         std::abs(e.delta_n) < 1e-6 && std::abs(e.omega_dot) < 1e-6 && std::abs(e.i_dot) < 1e-6 &&
         std::abs(e.af0) < 1 && std::abs(e.af1) < 1e-6 && std::abs(e.af2) < 1e-9 && std::abs(e.group_delay) < 1e-3 &&
         e.accuracy >= 0 && e.accuracy < 1e6 && std::abs(e.crc) < 1e6 && std::abs(e.crs) < 1e6 && std::abs(e.cuc) < 1 &&
         std::abs(e.cus) < 1 && std::abs(e.cic) < 1 && std::abs(e.cis) < 1;
}

}  // namespace binnacle::gnss
