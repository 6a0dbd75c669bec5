// SPDX-License-Identifier: Apache-2.0
// What pseudorange and range_rate have in common: the satellites of an epoch, as seen from the antenna.
#pragma once

#include <array>

#include "antenna.hpp"
#include "binnacle/measurement_model.hpp"
#include "gnss/corrections.hpp"
#include "satellite_limit.hpp"

namespace binnacle::gnss_range {

class RangeModel : public MeasurementModel {
 protected:
  using Sightings = std::array<gnss::Sighting, gnss::most_rows>;

  explicit RangeModel(const Binding& binding)
      : corrections_(binding),
        limit_(binding.parameters()),
        antenna_(binding),
        clock_(binding.port("clock")),
        ephemeris_(binding.input(gnss::ephemeris_port().name)),
        klobuchar_(binding.input(gnss::klobuchar_port().name)) {
    declaration_.rows(limit_.most()).reads(antenna_.port());
  }

  /// Satellites to be used; both models choose the same ones of an epoch.
  Result sight(const MeasurementInput& in, gnss::AntennaPlace& place, Sightings& sightings, int& count) const {
    const SampleView &ephemeris = in.auxiliary[ephemeris_], &klobuchar = in.auxiliary[klobuchar_];
    if (!ephemeris.available) return Result::unsupported("no broadcast ephemeris has come yet");
    if (corrections_.wants_klobuchar() && !klobuchar.available)
      return Result::unsupported("no ionosphere coefficients have come yet, or no channel is on input 'iono'");
    if (const Result result = antenna_.read(in.x, place); !result) return result;
    const gnss::Corrections::Tally tally =
        corrections_.sight({in.sample.t, &in.sample, &ephemeris, &klobuchar}, place, true, sightings);
    count = gnss::Corrections::keep_highest(sightings, tally.used, limit_.at(in.sample.t));
    if (count >= limit_.fewest()) return Result::ok();
    if (count > 0) return Result::unsupported("fewer satellites than 'min_satellites'");
    if (tally.used > 0) return Result::unsupported("a cut leaves no satellite");
    if (tally.without_ephemeris > 0) return Result::unsupported("no satellite in view has an ephemeris");
    return Result::unsupported("no satellite is above the masks");
  }

  gnss::Corrections corrections_;
  SatelliteLimit limit_;
  AntennaPosition antenna_;
  Port clock_;
  Input ephemeris_, klobuchar_;
};

/// The parameters, inputs and ports that both have.
inline void describe_range_model(ComponentSpec& spec) {
  for (auto& parameter : gnss::Corrections::parameters()) spec.parameters.push_back(std::move(parameter));
  for (auto& parameter : SatelliteLimit::parameters()) spec.parameters.push_back(std::move(parameter));
  spec.inputs = {gnss::ephemeris_port(), gnss::klobuchar_port()};
}

}  // namespace binnacle::gnss_range
