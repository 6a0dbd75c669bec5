// SPDX-License-Identifier: Apache-2.0
// From an epoch of observations to the satellites that are used and what each adds to its range.
#include "gnss/corrections.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "gnss/gps_time.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::gnss {

namespace {

constexpr double shortest_pseudorange = 1e6;  // m; clocks may be off by much, but light needs its time
constexpr double longest_pseudorange = 1e9;
constexpr double least_range = 1e6;                          // m, to a satellite
constexpr double lowest_orbit = 6.5e6, highest_orbit = 1e9;  // m from the earth's centre: kilometres are below

/// "G05", or the key of a row, "4301".
std::optional<SatelliteKey> excluded_key(std::string_view text) {
  const bool is_number = text.size() >= 3 && text.find_first_not_of("0123456789") == std::string_view::npos;
  if (!is_number) return parse_satellite(text);
  SatelliteKey key = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), key);
  return error == std::errc() ? std::optional(key) : std::nullopt;
}

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
          .about("true: correct for the rotation of the earth during the signal's travel (Sagnac); false: satellite "
                 "positions are already in the axes of reception"),
      boolean("satellite_clock").defaults("true").about("subtract the satellite's clock offset, including relativity"),
      boolean("group_delay")
          .defaults("true")
          .about("subtract T_GD, BGD, TGD1 from the satellite's clock offset, for single-frequency pseudoranges"),
      choice("ionosphere", {"none", "klobuchar"})
          .defaults("\"none\"")
          .about("model of the ionosphere; klobuchar: with the broadcast coefficients of the channel on 'iono'"),
      choice("troposphere", {"none", "saastamoinen"})
          .defaults("\"none\"")
          .about("model of the troposphere; saastamoinen: standard atmosphere, 70 % relative humidity"),
      choice("troposphere_mapping", {"niell", "cosecant"})
          .defaults("\"niell\"")
          .about("mapping from the zenith to the line of sight; cosecant: 1/sin(elevation), 0.2 m too large at 10 deg"),
      number("day_of_year", "1")
          .at_least(1)
          .below(367)
          .about("day of the year for the mapping niell, 1: the first of January; default: its mean over the year"),
      number("elevation_mask", "rad")
          .at_least(0)
          .below(M_PI / 2)
          .defaults("\"10 deg\"")
          .about("elevation below which satellites are not used"),
      number("cn0_mask", "1")
          .at_least(0)
          .defaults("0")
          .about("C/N0 below which signals are not used, if the channel gives it, dB-Hz"),
      list("exclude", text("satellite"))
          .about("satellites that are not used, for example \"G05\", \"E11\", \"C19\", or the key of a row, \"4301\""),
  };
}

Corrections::Corrections(const Binding& binding) {
  const Parameters& parameters = binding.parameters();
  earth_rotation_ = parameters.boolean("earth_rotation");
  satellite_clock_ = parameters.boolean("satellite_clock");
  group_delay_ = parameters.boolean("group_delay");
  klobuchar_ = parameters.text("ionosphere") == "klobuchar";
  saastamoinen_ = parameters.text("troposphere") == "saastamoinen";
  mapping_ = parameters.text("troposphere_mapping") == "niell" ? Mapping::niell : Mapping::cosecant;
  if (parameters.has("day_of_year")) {
    if (!saastamoinen_ || mapping_ != Mapping::niell)
      throw ComponentError(
          "the day of the year is for \"troposphere\": \"saastamoinen\" with \"troposphere_mapping\": \"niell\"",
          "/day_of_year");
    season_ = season_of(parameters.number("day_of_year"));
  }
  min_sin_elevation_ = std::sin(parameters.number("elevation_mask"));
  min_cn0_ = parameters.number("cn0_mask");
  if (!parameters.has("exclude")) return;
  const auto& names = parameters.list("exclude");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto key = excluded_key(names[i].text);
    if (!key)
      throw ComponentError("'" + names[i].text +
                               "' is not a satellite: \"G01\" … \"G32\", \"E01\" … \"E36\", \"C01\" … \"C63\", or the "
                               "key of a row with three digits or more, \"4301\"",
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
  for (int i = 0; i < epoch.observations->rows && tally.used < most_rows; ++i)
    take(epoch, tally, place, knows_place, i, out);
  return tally;
}

/// One row, as the next of `out` or as one more of those that are not used.
void Corrections::take(const Epoch& epoch, Tally& tally, const AntennaPlace& place, bool knows_place, int row,
                       std::array<Sighting, most_rows>& out) const {
  const SampleView& observations = *epoch.observations;
  Sighting& s = out[static_cast<std::size_t>(tally.used)];
  s = Sighting{};
  s.satellite = rows_.satellite(observations, row);
  s.pseudorange = rows_.pseudorange(observations, row);
  s.range_rate = rows_.range_rate(observations, row);
  if (s.satellite == 0 || !(s.pseudorange > shortest_pseudorange) || !(s.pseudorange < longest_pseudorange)) {
    ++tally.unusable;
    return;
  }
  s.cn0 = rows_.cn0(observations, row);
  if (is_excluded(s.satellite) || (min_cn0_ > 0 && s.cn0 < min_cn0_)) {  // false for NaN
    ++tally.masked;
    return;
  }
  s.system = rows_.system(observations, row, s.satellite);
  s.range_variance = rows_.range_variance(observations, row);
  s.rate_variance = rows_.rate_variance(observations, row);
  Sender sender;
  if (rows_.are_given()) {
    const auto end = out.begin() + tally.used;
    if (std::any_of(out.begin(), end, [&](const Sighting& other) { return other.satellite == s.satellite; })) {
      ++tally.repeated;
      return;
    }
    if (!by_row(observations, row, sender)) {
      ++tally.misplaced;
      return;
    }
  } else {
    const double* message = find_ephemeris(*epoch.ephemerides, s.satellite);
    const Ephemeris ephemeris = message ? read_ephemeris(message) : Ephemeris{};
    if (!message || !is_usable(ephemeris)) {
      ++tally.without_ephemeris;
      return;
    }
    sender = by_ephemeris(epoch, s.pseudorange, ephemeris);
  }
  ++(correct(epoch, place, knows_place, sender, s) ? tally.used : tally.masked);
}

/// The label of an epoch and its pseudoranges belong to one clock, the receiver's: label − ρ / c is the satellite's own
/// time of transmission, whatever the receiver's clock error (IS-GPS-200 20.3.3.3.3.1).
Corrections::Sender Corrections::by_ephemeris(const Epoch& epoch, double pseudorange,
                                              const Ephemeris& ephemeris) const {
  double back = pseudorange / speed_of_light;
  if (satellite_clock_) back += satellite_clock(ephemeris, epoch.t, back);
  return {satellite_state(ephemeris, epoch.t, back), ephemeris.group_delay, ephemeris.accuracy};
}

/// As the channel carries it. False: its position is none of a satellite, or a clock is missing that others have.
bool Corrections::by_row(const SampleView& observations, int row, Sender& sender) const {
  SatelliteState& state = sender.state;
  state.position = rows_.position(observations, row);
  const double distance = state.position.norm();
  if (!(distance > lowest_orbit && distance < highest_orbit)) return false;
  state.velocity = Eigen::Vector3d::Zero();
  if (rows_.has_velocity()) state.velocity = rows_.velocity(observations, row);
  if (rows_.has_clock()) state.clock = rows_.clock(observations, row);
  if (rows_.has_clock_drift()) state.clock_drift = rows_.clock_drift(observations, row);
  constexpr double most_clock = 1, most_drift = 1e-3;  // s, s/s: what is beyond is no satellite's
  return std::abs(state.clock) <= most_clock && std::abs(state.clock_drift) <= most_drift;  // false for NaN
}

bool Corrections::correct(const Epoch& epoch, const AntennaPlace& place, bool knows_place, const Sender& sender,
                          Sighting& s) const {
  const SatelliteState& state = sender.state;
  s.velocity = state.velocity;
  s.path = signal_path(state.position, place.ecef, earth_rotation_);
  if (!(s.path.range > least_range)) return false;
  s.accuracy = sender.accuracy;
  if (satellite_clock_) {
    s.delay -= speed_of_light * state.clock;
    s.rate_delay = -speed_of_light * state.clock_drift;
  }
  if (group_delay_) s.delay += speed_of_light * sender.group_delay;
  if (!knows_place) return true;
  s.direction = direction_in(place.C_en, s.path.direction);
  const double sine = std::sin(s.direction.elevation);
  if (sine < min_sin_elevation_ || sine < 0) return false;
  const double elevation = std::asin(std::max(sine, least_sine));
  if (klobuchar_) {
    s.ionosphere = klobuchar_delay(read_klobuchar(epoch.klobuchar->fields), place.lla[0], place.lla[1],
                                   s.direction.azimuth, s.direction.elevation, time_of_day(epoch.t));
    if (const double f = rows_.are_given() ? l1_frequency : carrier_frequency(s.satellite); f != l1_frequency)
      s.ionosphere *= (l1_frequency / f) * (l1_frequency / f);  // dispersive: as 1/f²
    s.delay += s.ionosphere;
  }
  if (saastamoinen_) {
    const TroposphereDelay troposphere = troposphere_delay(mapping_, place.lla[0], place.lla[2], elevation, season_);
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

}  // namespace binnacle::gnss
