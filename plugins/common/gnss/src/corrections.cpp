// SPDX-License-Identifier: Apache-2.0
// From an epoch of observations to the satellites that are used and what each adds to its range.
#include "gnss/corrections.hpp"

#include <algorithm>
#include <cmath>

#include "gnss/gps_time.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::gnss {

namespace {

constexpr double shortest_pseudorange = 1e6;  // m; clocks may be off by much, but light needs its time
constexpr double longest_pseudorange = 1e9;
constexpr double least_range = 1e6;   // m, to a satellite
constexpr double least_sine = 0.017;  // of elevation, where a mapping 1/sin is cut off: 1 deg

double squared(double x) { return x * x; }

}  // namespace

AntennaPlace place_from_ecef(const Eigen::Vector3d& ecef) {
  const Eigen::Vector3d lla = strapdown::lla_from_ecef(ecef);
  return {ecef, lla, strapdown::C_en(lla[0], lla[1])};
}

AntennaPlace place_from_lla(const Eigen::Vector3d& lla) {
  return {strapdown::ecef_from_lla(lla), lla, strapdown::C_en(lla[0], lla[1])};
}

std::vector<ParameterSpec> Corrections::parameters() {
  using namespace parameter;
  return {
      boolean("earth_rotation")
          .defaults("true")
          .about("the earth turns while the signal travels (Sagnac); false: satellites stand in the axes of reception"),
      boolean("satellite_clock").defaults("true").about("subtract the satellite's clock, relativity included"),
      boolean("group_delay").defaults("true").about("subtract T_GD, BGD from the satellite's clock: one frequency"),
      choice("ionosphere", {"none", "klobuchar"})
          .defaults("\"none\"")
          .about("klobuchar: by the broadcast coefficients of the channel on 'iono'"),
      choice("troposphere", {"none", "saastamoinen"})
          .defaults("\"none\"")
          .about("saastamoinen: standard atmosphere, 70 % relative humidity"),
      number("elevation_mask", "rad")
          .at_least(0)
          .below(M_PI / 2)
          .defaults("\"10 deg\"")
          .about("satellites below it are not used"),
      number("cn0_mask", "1").at_least(0).defaults("0").about("dB-Hz; weaker signals are not used, where it is given"),
      list("exclude", text("satellite")).about("satellites that are not used: \"G05\", \"E11\""),
  };
}

Corrections::Corrections(const Binding& binding) {
  const Parameters& parameters = binding.parameters();
  earth_rotation_ = parameters.boolean("earth_rotation");
  satellite_clock_ = parameters.boolean("satellite_clock");
  group_delay_ = parameters.boolean("group_delay");
  klobuchar_ = parameters.text("ionosphere") == "klobuchar";
  saastamoinen_ = parameters.text("troposphere") == "saastamoinen";
  min_sin_elevation_ = std::sin(parameters.number("elevation_mask"));
  min_cn0_ = parameters.number("cn0_mask");
  if (!parameters.has("exclude")) return;
  const auto& names = parameters.list("exclude");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto key = parse_satellite(names[i].text);
    if (!key)
      throw ComponentError("'" + names[i].text + "' is no satellite: \"G01\" … \"G32\", \"E01\" … \"E36\"",
                           "/exclude/" + std::to_string(i));
    excluded_.push_back(*key);
  }
}

bool Corrections::is_excluded(SatelliteKey key) const {
  return std::find(excluded_.begin(), excluded_.end(), key) != excluded_.end();
}

Corrections::Tally Corrections::sight(const Epoch& epoch, const AntennaPlace& place, bool knows_place,
                                      std::array<Sighting, most_rows>& out) const {
  Tally tally;
  for (int i = 0; i < epoch.observations->rows && tally.used < most_rows; ++i) {
    const double* row = epoch.observations->row_fields + i * observation::field_count;
    Sighting& sighting = out[static_cast<std::size_t>(tally.used)];
    sighting = Sighting{};
    sighting.satellite = satellite_key(row[observation::satellite]);
    sighting.pseudorange = row[observation::pseudorange];
    sighting.range_rate = row[observation::range_rate];
    if (sighting.satellite == 0 || !(sighting.pseudorange > shortest_pseudorange) ||
        !(sighting.pseudorange < longest_pseudorange)) {
      ++tally.unusable;
      continue;
    }
    if (is_excluded(sighting.satellite) || row[observation::cn0] < min_cn0_) {  // false for NaN
      ++tally.masked;
      continue;
    }
    const double* message = find_ephemeris(*epoch.ephemerides, sighting.satellite);
    const Ephemeris ephemeris = message ? read_ephemeris(message) : Ephemeris{};
    if (!message || !is_usable(ephemeris)) {
      ++tally.without_ephemeris;
      continue;
    }
    if (correct(epoch, place, knows_place, sighting, ephemeris)) {
      ++tally.used;
    } else {
      ++tally.masked;
    }
  }
  return tally;
}

/// The label of an epoch and its pseudoranges belong to one clock, the receiver's: label − ρ / c is the satellite's own
/// time of transmission, whatever the receiver's clock error (IS-GPS-200 20.3.3.3.3.1).
bool Corrections::correct(const Epoch& epoch, const AntennaPlace& place, bool knows_place, Sighting& s,
                          const Ephemeris& ephemeris) const {
  double back = s.pseudorange / speed_of_light;
  if (satellite_clock_) back += satellite_clock(ephemeris, epoch.t, back);
  const SatelliteState state = satellite_state(ephemeris, epoch.t, back);
  s.velocity = state.velocity;
  s.path = signal_path(state.position, place.ecef, earth_rotation_);
  if (!(s.path.range > least_range)) return false;
  s.accuracy = ephemeris.accuracy;
  if (satellite_clock_) {
    s.delay -= speed_of_light * state.clock;
    s.rate_delay = -speed_of_light * state.clock_drift;
  }
  if (group_delay_) s.delay += speed_of_light * ephemeris.group_delay;
  if (!knows_place) return true;
  s.direction = direction_in(place.C_en, s.path.direction);
  const double sine = std::sin(s.direction.elevation);
  if (sine < min_sin_elevation_ || sine < 0) return false;
  const double elevation = std::asin(std::max(sine, least_sine));
  if (klobuchar_) {
    s.ionosphere = klobuchar_delay(read_klobuchar(epoch.klobuchar->fields), place.lla[0], place.lla[1],
                                   s.direction.azimuth, s.direction.elevation, time_of_day(epoch.t));
    s.delay += s.ionosphere;
  }
  if (saastamoinen_) {
    const TroposphereDelay troposphere = saastamoinen_delay(place.lla[0], place.lla[2], elevation);
    s.delay += troposphere.delay;
    s.d_delay_down = -troposphere.d_height;
  }
  return true;
}

int Corrections::keep_highest(std::array<Sighting, most_rows>& sightings, int count, int most) {
  for (; count > most; --count) {
    const auto end = sightings.begin() + count;
    const auto lowest = std::min_element(sightings.begin(), end, [](const Sighting& a, const Sighting& b) {
      return a.direction.elevation < b.direction.elevation;
    });
    std::move(lowest + 1, end, lowest);
  }
  return count;
}

std::vector<ParameterSpec> ElevationNoise::parameters(const char* unit, bool with_path_errors,
                                                      const char* default_sigma) {
  using namespace parameter;
  constexpr double least = 1e-4, most = 1e3;
  std::vector<ParameterSpec> specs{
      number("sigma", unit)
          .at_least(0)
          .plausible(least, most)
          .defaults(default_sigma)
          .about("standard deviation straight up: sigma^2 + (sigma_elevation / sin el)^2 + …"),
      number("sigma_elevation", unit)
          .at_least(0)
          .plausible(least, most)
          .defaults("0")
          .about("part of it that grows with 1 / sin(elevation)")};
  if (with_path_errors) {
    specs.push_back(
        number("sigma_ionosphere", "1")
            .at_least(0)
            .defaults("0")
            .about("standard deviation of the ionosphere correction as a part of it; Klobuchar's leaves half"));
    specs.push_back(number("sigma_accuracy", "1")
                        .at_least(0)
                        .defaults("0")
                        .about("factor on the accuracy that the message gives (URA, SISA)"));
  }
  return specs;
}

ElevationNoise::ElevationNoise(const Parameters& parameters, bool with_path_errors)
    : sigma_(parameters.number("sigma")), by_elevation_(parameters.number("sigma_elevation")) {
  if (sigma_ == 0 && by_elevation_ == 0)
    throw ComponentError("sigma and sigma_elevation are both zero: a measurement has some noise", "/sigma");
  if (!with_path_errors) return;
  ionosphere_ = parameters.number("sigma_ionosphere");
  accuracy_ = parameters.number("sigma_accuracy");
}

double ElevationNoise::variance(const Sighting& s) const {
  const double sine = std::max(std::sin(s.direction.elevation), least_sine);
  return squared(sigma_) + squared(by_elevation_ / sine) + squared(ionosphere_ * s.ionosphere) +
         (accuracy_ > 0 ? squared(accuracy_ * s.accuracy) : 0.0);
}

}  // namespace binnacle::gnss
