// SPDX-License-Identifier: Apache-2.0
// What pseudorange and range_rate have in common: the satellites of an epoch, as seen from the antenna.
#include "range_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

namespace binnacle::gnss_range {

namespace {

std::vector<std::int64_t> read_systems(const Parameters& parameters, const gnss::ObservationRows& rows) {
  std::vector<std::int64_t> systems;
  if (!parameters.has("systems")) {
    if (rows.has_system())
      throw ComponentError(
          "the channel carries 'system': list the numbers to be used, first the system to which the receiver's clock "
          "refers: \"systems\": [1, 8]",
          "/systems");
    return systems;
  }
  const auto& list = parameters.list("systems");
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (std::find(systems.begin(), systems.end(), list[i].integer) != systems.end())
      throw ComponentError("system " + std::to_string(list[i].integer) + " stands here twice",
                           "/systems/" + std::to_string(i));
    systems.push_back(list[i].integer);
  }
  if (systems.empty()) throw ComponentError("no system is listed, so that no row could be used", "/systems");
  return systems;
}

}  // namespace

void describe_range_model(ComponentSpec& spec, bool rate_is_optional) {
  for (auto& parameter : gnss::Corrections::parameters()) spec.parameters.push_back(std::move(parameter));
  for (auto& parameter : SatelliteLimit::parameters()) spec.parameters.push_back(std::move(parameter));
  spec.parameters.push_back(parameter::list("systems", parameter::integer("system").at_least(0))
                                .about("numbers of the satellite systems to be used, first the system to which the "
                                       "receiver's clock refers; rows of others are not used. Default: all systems"));
  spec.inputs = {gnss::ephemeris_port(), gnss::klobuchar_port()};
  spec.inputs[0].is_optional = true;
  spec.inputs[0].text += "; not needed if the channel gives the satellites' positions";
  spec.fields = gnss::observation_fields(rate_is_optional);
  for (auto& field : gnss::given_fields()) spec.fields.push_back(std::move(field));
}

RangeModel::RangeModel(const Binding& binding, gnss::RangeNoise::Of of)
    : rows_(binding),
      corrections_(binding),
      limit_(binding.parameters()),
      antenna_(binding),
      clock_(binding.port("clock")),
      noise_(binding.parameters(), of),
      systems_(read_systems(binding.parameters(), rows_)),
      ephemeris_(binding.input(gnss::ephemeris_port().name)),
      klobuchar_(binding.input(gnss::klobuchar_port().name)) {
  if (rows_.are_given() == ephemeris_.is_bound())
    throw ComponentError(
        ephemeris_.is_bound()
            ? "the channel gives the satellites' positions (satellite_x …): remove the input 'ephemeris', which would "
              "be a second source"
            : "an ephemeris is needed on input 'ephemeris', or the satellites' positions on the channel: satellite_x, "
              "satellite_y, satellite_z",
        "/inputs/ephemeris");
  if (noise_.needs_cn0() && !rows_.has_cn0())
    throw ComponentError("the noise goes by C/N0, and the channel carries no 'cn0'", "/channel");
  corrections_.read_rows_as(rows_);
  declaration_.rows(limit_.most()).reads(antenna_.port());
}

int RangeModel::system_of(const gnss::Sighting& sighting) const {
  const auto found = std::find(systems_.begin(), systems_.end(), sighting.system);
  return found == systems_.end() ? -1 : static_cast<int>(found - systems_.begin());
}

Result RangeModel::sight(const MeasurementInput& in, gnss::AntennaPlace& place, Sightings& sightings,
                         int& count) const {
  const SampleView *ephemeris = nullptr, &klobuchar = in.auxiliary[klobuchar_];
  if (!rows_.are_given()) {
    ephemeris = &in.auxiliary[ephemeris_];
    if (!ephemeris->available) return Result::unsupported("no broadcast ephemeris has come yet");
  }
  if (corrections_.wants_klobuchar() && !klobuchar.available)
    return Result::unsupported("no ionosphere coefficients have come yet, or no channel is on input 'iono'");
  if (const Result result = antenna_.read(in.x, place); !result) return result;
  const gnss::Corrections::Tally tally =
      corrections_.sight({in.sample.t, &in.sample, ephemeris, &klobuchar}, place, true, sightings);
  if (tally.misplaced > 0) in.notes.leave("a row is left out: its satellite has no valid position or clock");
  if (tally.repeated > 0) in.notes.leave("a row is left out: its satellite has one in this epoch already");
  const int usable = keep_usable(in.notes, sightings, tally.used);
  count = gnss::Corrections::keep_highest(sightings, usable, limit_.at(in.sample.t));
  if (count >= limit_.fewest()) return Result::ok();
  if (count > 0) return Result::unsupported("fewer satellites than 'min_satellites'");
  if (usable > 0) return Result::unsupported("a cut leaves no satellite");
  if (tally.used > 0) return Result::unsupported("no satellite in view is of one of the 'systems' and has a variance");
  if (tally.without_ephemeris > 0) return Result::unsupported("no satellite in view has an ephemeris");
  if (tally.misplaced > 0) return Result::unsupported("no satellite in view has a valid position");
  return Result::unsupported("no satellite is above the masks");
}

/// Without rows of systems that are not listed and rows whose noise is not known; each is noted.
int RangeModel::keep_usable(const Notes& notes, Sightings& sightings, int count) const {
  if (!has_systems() && !noise_.needs_cn0() && !rows_.has_variance()) return count;
  const auto is_unusable = [&](const gnss::Sighting& s) {
    if (has_systems() && system_of(s) < 0) {
      char text[96];
      std::snprintf(text, sizeof text, "rows of system %lld are left out: it is none of 'systems'",
                    static_cast<long long>(s.system));
      notes.leave(text);
      return true;
    }
    if (const double variance = noise_.variance(s); variance > 0 && std::isfinite(variance)) return false;
    notes.leave("a row is left out: it has no C/N0, or a variance that is not positive and finite");
    return true;
  };
  const auto end = sightings.begin() + count;
  return static_cast<int>(std::remove_if(sightings.begin(), end, is_unusable) - sightings.begin());
}

}  // namespace binnacle::gnss_range
