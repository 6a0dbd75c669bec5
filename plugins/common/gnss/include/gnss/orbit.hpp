// SPDX-License-Identifier: Apache-2.0
// Broadcast orbit and clock of a satellite.
#pragma once

#include <Eigen/Core>

#include "binnacle/time.hpp"
#include "gnss/satellite.hpp"

namespace binnacle::gnss {

inline constexpr double speed_of_light = 299792458.0;  ///< m/s
inline constexpr double omega_e = 7.2921151467e-5;     ///< rad/s, earth rotation of IS-GPS-200 and Galileo's OS SIS ICD
inline constexpr double l1_frequency = 1575.42e6;      ///< Hz; Galileo's E1 too
inline constexpr double b1_frequency = 1561.098e6;     ///< Hz, BeiDou's B1I

/// Of the signal whose pseudoranges are used [Hz].
constexpr double carrier_frequency(SatelliteKey key) noexcept {
  return constellation_of(key) == Constellation::beidou ? b1_frequency : l1_frequency;
}

/// A broadcast message in SI: IS-GPS-200 table 20-IV and 20.3.3.3, Galileo OS SIS ICD tables 57 to 60;
/// BeiDou BDS-SIS-ICD-B1I-3.0 tables 5-8 to 5-10.
/// Times are seconds on the clock of the channel that carries it (gps_time.hpp).
struct Ephemeris {
  SatelliteKey satellite = 0;
  double toe = 0;              // s, reference time of the orbit
  double toc = 0;              // s, of the clock
  double semi_major_axis = 0;  // m
  double eccentricity = 0;
  double i0 = 0;            // rad, inclination at toe
  double omega0 = 0;        // rad, longitude of the ascending node at the begin of the week
  double perigee = 0;       // rad, argument of perigee
  double m0 = 0;            // rad, mean anomaly at toe
  double delta_n = 0;       // rad/s
  double omega_dot = 0;     // rad/s
  double i_dot = 0;         // rad/s
  double cuc = 0, cus = 0;  // rad, argument of latitude
  double crc = 0, crs = 0;  // m, radius
  double cic = 0, cis = 0;  // rad, inclination
  double af0 = 0;           // s
  double af1 = 0;           // s/s
  double af2 = 0;           // s/s²
  double group_delay = 0;  // s: T_GD, Galileo's BGD, BeiDou's TGD1; a single-frequency user subtracts it from the clock
  double accuracy = 0;     // m: URA, SISA
  double issue = 0;        // IODE, IODnav
};

/// In ECEF axes of the instant itself (no rotation during the travel of a signal).
struct SatelliteState {
  Eigen::Vector3d position;  // m
  Eigen::Vector3d velocity;  // m/s, relative to the earth
  double clock = 0;          // s: polynomial and relativity, without group delay. Satellite time − system time
  double clock_drift = 0;    // s/s
};

/// The eccentric anomaly: E − e sin E = M. Newton's method, from a start that makes it converge for every e < 1.
double eccentric_anomaly(double mean_anomaly, double eccentricity);

/// Orbit and clock `back` seconds before t. IS-GPS-200 table 20-IV; BeiDou's geostationary satellites (C01 to C05, C59 to
/// C63) after BDS-SIS-ICD-B1I-3.0 table 5-11; velocity by differentiating it; relativity
/// F e √A sin E, F = −2 √μ / c² (20.3.3.3.3.1).
SatelliteState satellite_state(const Ephemeris& ephemeris, Time t, double back = 0);

/// Satellite time − system time [s] by the polynomial and relativity alone.
double satellite_clock(const Ephemeris& ephemeris, Time t, double back);

/// The orbit and clock are numbers, and the orbit is one of a satellite: what a message must be to be used.
bool is_usable(const Ephemeris& ephemeris);

}  // namespace binnacle::gnss
