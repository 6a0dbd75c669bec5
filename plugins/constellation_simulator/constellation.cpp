// SPDX-License-Identifier: Apache-2.0
// Which satellites there are.
#include "constellation.hpp"

#include <cmath>
#include <numbers>

namespace binnacle::constellation_simulator {

namespace {

constexpr double turn = 2.0 * std::numbers::pi;

}  // namespace

std::vector<ParameterSpec> constellation_parameters() {
  using namespace parameter;
  return {
      object(
          "constellation",
          {integer("satellites").at_least(1).at_most(32).defaults("24").about("number of satellites"),
           integer("planes").at_least(1).at_most(32).defaults("6").about(
               "number of orbit planes, evenly spaced around the equator"),
           integer("phasing").at_least(0).at_most(31).defaults("1").about(
               "phase between neighbours in adjacent planes, in units of a revolution / satellites"),
           number("inclination", "rad").defaults("\"55 deg\"").about("inclination of every plane"),
           number("radius", "m").above(1e7).below(1e8).defaults("\"26560 km\"").about("radius of the circular orbits"),
           number("node", "rad")
               .defaults("0")
               .about("longitude of the first plane's ascending node at the start of the week")})
          .defaults("{}")
          .about("a regular constellation"),
      path("almanac").about("YUMA almanac file, instead of the regular constellation")};
}

std::vector<gnss::Ephemeris> read_constellation(const Binding& binding) {
  if (binding.parameters().has("almanac")) return read_almanac(binding.parameters().text("almanac"));
  const Parameters parameters = binding.parameters().object("constellation");
  const auto satellites = static_cast<int>(parameters.integer("satellites"));
  const auto planes = static_cast<int>(parameters.integer("planes"));
  if (satellites % planes != 0)
    throw ComponentError("the satellites do not fill the planes evenly", "/constellation/planes");
  const int in_plane = satellites / planes;
  const double phase = turn * static_cast<double>(parameters.integer("phasing")) / satellites;
  std::vector<gnss::Ephemeris> constellation;
  for (int i = 0; i < satellites; ++i) {
    const int plane = i / in_plane;
    gnss::Ephemeris satellite;
    satellite.satellite = gnss::satellite_key(gnss::Constellation::gps, i + 1);
    satellite.semi_major_axis = parameters.number("radius");
    satellite.i0 = parameters.number("inclination");
    satellite.omega0 = parameters.number("node") + turn * plane / planes;
    satellite.m0 = std::remainder(turn * (i % in_plane) / in_plane + phase * plane, turn);
    constellation.push_back(satellite);
  }
  return constellation;
}

}  // namespace binnacle::constellation_simulator
