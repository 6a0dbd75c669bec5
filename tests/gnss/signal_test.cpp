// SPDX-License-Identifier: Apache-2.0
// Broadcast orbits, signal path and atmosphere: against what is published, and against themselves differentiated.
#include <cmath>

#include "catch.hpp"
#include "gnss/atmosphere.hpp"
#include "gnss/gps_time.hpp"
#include "gnss/orbit.hpp"
#include "gnss/satellite.hpp"
#include "gnss/signal_path.hpp"
#include "sky.hpp"
#include "strapdown/earth.hpp"

namespace signal_test {

using namespace binnacle;
using namespace binnacle::gnss;
using Eigen::Vector3d;

TEST_CASE("weeks and seconds of dates") {
  // IGS calendar: 2005-04-02 is day 6 of week 1316, 2021-03-19 day 5 of week 2149, 2021-11-09 day 2 of week 2183.
  CHECK(gps_day(1980, 1, 6) == 0);
  CHECK(gps_day(2005, 4, 2) == 1316 * 7 + 6);
  CHECK(gps_day(2021, 3, 19) == 2149 * 7 + 5);
  CHECK(gps_day(2021, 11, 9) == 2183 * 7 + 2);
  CHECK(gps_day(2000, 2, 29) + 1 == gps_day(2000, 3, 1));
  CHECK(time_of_week(604800.0 * 5 + 17) == 17);
  CHECK(time_of_week(-1) == 604799);
  CHECK(time_of_day(nanoseconds(86400.0 * 3 + 0.5)) == 0.5);
}

TEST_CASE("satellites and their names") {
  CHECK(parse_satellite("G05") == 105);
  CHECK(parse_satellite("G 5") == 105);
  CHECK(parse_satellite(" 5") == 105);
  CHECK(parse_satellite("  5") == 105);
  CHECK(parse_satellite("E11") == 211);
  for (const char* bad : {"", "G", "G00", "G33", "E37", "R01", "G1x", "xx", "G-1"}) CHECK_FALSE(parse_satellite(bad));
  for (const SatelliteKey key : {101, 132, 201, 236}) CHECK(parse_satellite(satellite_name(key)) == key);
  CHECK(satellite_key(105.0) == 105);
  for (const double bad : {0.0, 100.0, 300.0, -5.0, 1e300, std::nan("")}) CHECK(satellite_key(bad) == 0);
}

TEST_CASE("Kepler's equation holds for every orbit") {
  for (const double e : {0.0, 1e-6, 0.01, 0.2, 0.5, 0.9, 0.99})
    for (double M = -7; M < 7; M += 0.37) {
      const double E = eccentric_anomaly(M, e);
      CHECK(std::abs(std::remainder(E - e * std::sin(E) - M, 2 * M_PI)) < 1e-13);
    }
}

TEST_CASE("velocity and clock drift are the derivatives of position and clock") {
  const test::Sky sky;
  for (const Ephemeris& e : sky.ephemerides)
    for (const double t : {0.0, 5000.0, 14000.0}) {
      const auto state = [&](double dt) { return test::Sky::state(e, t + dt); };
      const double h = 0.5;
      const Vector3d v =
          (8 * (state(h).position - state(-h).position) - (state(2 * h).position - state(-2 * h).position)) / (12 * h);
      const double drift = (state(100).clock - state(-100).clock) / 200;
      CHECK((v - state(0).velocity).norm() < 2e-6);
      CHECK(std::abs(drift - state(0).clock_drift) < 1e-15);
      CHECK(satellite_clock(e, 0, -t) == state(0).clock);
    }
}

TEST_CASE("a circular orbit without corrections is circled at Kepler's rate") {
  Ephemeris e;
  e.satellite = 101;
  e.semi_major_axis = 26560e3;
  e.i0 = 55 * M_PI / 180;
  const double rate = std::sqrt(3.986005e14 / std::pow(e.semi_major_axis, 3));
  for (const double t : {0.0, 3000.0, 20000.0}) {
    const SatelliteState s = test::Sky::state(e, t);
    CHECK(std::abs(s.position.norm() - e.semi_major_axis) < 1e-6);
    const Vector3d inertial = test::Sky::inertial(s.position, t);
    const Vector3d expected = e.semi_major_axis * Vector3d(std::cos(rate * t), std::sin(rate * t) * std::cos(e.i0),
                                                           std::sin(rate * t) * std::sin(e.i0));
    CHECK((inertial - expected).norm() < 1e-5);
    // In inertial axes the speed is √(μ/a).
    const Vector3d v = s.velocity + omega_e * Vector3d::UnitZ().cross(s.position);
    CHECK(std::abs(v.norm() - std::sqrt(3.986005e14 / e.semi_major_axis)) < 1e-6);
    CHECK(s.clock == 0);
  }
}

TEST_CASE("Galileo has its own gravitational constant") {
  Ephemeris e;
  e.semi_major_axis = 29600e3;
  e.satellite = 101;
  const Vector3d as_gps = test::Sky::state(e, 7200).position;
  e.satellite = 211;
  const double moved = (test::Sky::state(e, 7200).position - as_gps).norm();
  const double expected = 0.5 * (3.986005e14 - 3.986004418e14) / 3.986005e14 *
                          std::sqrt(3.986005e14 / std::pow(e.semi_major_axis, 3)) * 7200 * e.semi_major_axis;
  CHECK(std::abs(moved - expected) < 0.01 * expected);
}

TEST_CASE("a message that is none of a satellite is not usable") {
  const test::Sky sky;
  CHECK(is_usable(sky.ephemerides[0]));
  const auto broken = [&](auto change) {
    Ephemeris e = sky.ephemerides[0];
    change(e);
    return !is_usable(e);
  };
  CHECK(broken([](Ephemeris& e) { e.semi_major_axis = 0; }));
  CHECK(broken([](Ephemeris& e) { e.eccentricity = 1.5; }));
  CHECK(broken([](Ephemeris& e) { e.m0 = std::nan(""); }));
  CHECK(broken([](Ephemeris& e) { e.toe = 1e300; }));
  CHECK(broken([](Ephemeris& e) { e.satellite = 0; }));
}

TEST_CASE("Klobuchar's delay in a published example") {
  // J. A. Klobuchar, "Ionospheric Effects on GPS", in Parkinson and Spilker (1996) vol. I ch. 12; as worked in
  // Strang and Borre, Linear Algebra, Geodesy, and GPS (1997): 40 N, 100 W, elevation 20, azimuth 210, 20:45 UT.
  const Klobuchar model{{3.82e-8, 1.49e-8, -1.79e-7, 0}, {1.43e5, 0, -3.28e5, 1.13e5}};
  const double degree = M_PI / 180;
  CHECK(std::abs(klobuchar_delay(model, 40 * degree, 260 * degree, 210 * degree, 20 * degree, 20.75 * 3600) - 23.784) <
        1e-3);
  // At night it is 5 ns times the slant.
  const double slant = 1 + 16 * std::pow(0.53 - 0.5, 3);
  CHECK(std::abs(klobuchar_delay(model, 40 * degree, 0, 0, 90 * degree, 2 * 3600.0) - slant * 5e-9 * speed_of_light) <
        1e-9);
}

TEST_CASE("Saastamoinen's delay: the zenith, the slant, and its change with height") {
  const auto delay = [](Mapping mapping, double lat, double height, double elevation) {
    return troposphere_delay(mapping, lat, height, elevation, 0.4);
  };
  // Dry: 0.0022768 · 1013.25 / (1 − 0.00266 cos 2φ) = 2.307 m at 45°; wet with 70 % humidity at 15 °C: 0.11 m.
  const double zenith = delay(Mapping::cosecant, M_PI / 4, 0, M_PI / 2).delay;
  CHECK(std::abs(zenith - 2.42) < 0.02);
  CHECK(std::abs(delay(Mapping::niell, M_PI / 4, 0, M_PI / 2).delay - zenith) < 1e-12);
  CHECK(std::abs(delay(Mapping::cosecant, M_PI / 4, 0, M_PI / 6).delay - 2 * zenith) < 1e-12);
  for (const auto mapping : {Mapping::niell, Mapping::cosecant}) {
    CHECK(delay(mapping, M_PI / 4, 8848, M_PI / 2).delay < 0.4 * zenith);
    for (const double h : {-100.0, 0.0, 500.0, 5000.0, 15000.0}) {
      const auto at = [&](double height) { return delay(mapping, 0.6, height, 0.1); };
      CHECK(std::abs((at(h + 1).delay - at(h - 1).delay) / 2 - at(h).d_height) <
            1e-7 * std::abs(at(h).d_height) + 1e-10);
    }
    for (const double h : {-1e9, 40e3, 1e300}) {
      CHECK(std::isfinite(delay(mapping, 0.6, h, 0.3).delay));
      CHECK(delay(mapping, 0.6, h, 0.3).d_height == 0);
    }
  }
}

TEST_CASE("the way of a signal: light time and its derivatives") {
  const test::Sky sky;
  const Vector3d antenna = strapdown::ecef_from_lla({0.6, 2.2, 100});
  const Vector3d v(60, -30, 20);
  for (const Ephemeris& e : sky.ephemerides) {
    const SatelliteState s = test::Sky::state(e, 1234);
    const SignalPath path = signal_path(s.position, antenna, true);
    // In inertial axes that agree with the earth's at transmission.
    const double travel = path.range / speed_of_light;
    CHECK(std::abs((test::Sky::inertial(antenna, travel) - s.position).norm() - path.range) < 1e-6);
    CHECK(std::abs(signal_path(s.position, antenna, false).range - (s.position - antenna).norm()) == 0);
    for (int i = 0; i < 3; ++i) {
      const Vector3d d = 100 * Vector3d::Unit(i);
      const double slope =
          (signal_path(s.position, antenna + d, true).range - signal_path(s.position, antenna - d, true).range) / 200;
      CHECK(std::abs(slope + path.scale * path.direction[i]) < 2e-9);
      const auto rate = [&](const Vector3d& r, const Vector3d& u) {
        return range_rate(signal_path(s.position, r, true), s.velocity, u, true).rate;
      };
      const RangeRate at = range_rate(path, s.velocity, v, true);
      CHECK(std::abs((rate(antenna, v + Vector3d::Unit(i)) - rate(antenna, v - Vector3d::Unit(i))) / 2 -
                     at.by_velocity[i]) < 1e-9);
      CHECK(std::abs((rate(antenna + d, v) - rate(antenna - d, v)) / 200 - at.by_position[i]) < 1e-8);
    }
  }
}

TEST_CASE("azimuth and elevation") {
  const Eigen::Matrix3d C = strapdown::C_en(0.6, 2.2);
  const auto seen = [&](double n, double e, double d) { return direction_in(C, C * Vector3d(n, e, d).normalized()); };
  CHECK(std::abs(seen(1, 0, 0).azimuth) < 1e-12);
  CHECK(std::abs(seen(0, 1, 0).azimuth - M_PI / 2) < 1e-12);
  CHECK(std::abs(seen(0, -1, 0).azimuth - 3 * M_PI / 2) < 1e-12);
  CHECK(std::abs(seen(0, 1, -1).elevation - M_PI / 4) < 1e-12);
}

}  // namespace signal_test
