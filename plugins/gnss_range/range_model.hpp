// SPDX-License-Identifier: Apache-2.0
// What pseudorange and range_rate have in common: the satellites of an epoch, as seen from the antenna.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "antenna.hpp"
#include "binnacle/measurement_model.hpp"
#include "gnss/corrections.hpp"
#include "gnss/range_noise.hpp"
#include "satellite_limit.hpp"

namespace binnacle::gnss_range {

class RangeModel : public MeasurementModel {
 protected:
  using Sightings = std::array<gnss::Sighting, gnss::most_rows>;

  RangeModel(const Binding& binding, gnss::RangeNoise::Of of);

  /// Satellites to be used. Both models choose the same ones of an epoch, but for rows without a variance.
  Result sight(const MeasurementInput& in, gnss::AntennaPlace& place, Sightings& sightings, int& count) const;
  /// Which of `systems` a satellite is of; −1: none.
  int system_of(const gnss::Sighting& sighting) const;
  bool has_systems() const noexcept { return !systems_.empty(); }

  gnss::ObservationRows rows_;
  gnss::Corrections corrections_;
  SatelliteLimit limit_;
  AntennaPosition antenna_;
  Port clock_;
  gnss::RangeNoise noise_;
  std::vector<std::int64_t> systems_;  // empty: whatever comes, all on one clock

 private:
  int keep_usable(const Notes& notes, Sightings& sightings, int count) const;

  Input ephemeris_, klobuchar_;
};

/// The parameters, inputs, fields and ports that both have.
void describe_range_model(ComponentSpec& spec, bool rate_is_optional);

}  // namespace binnacle::gnss_range
