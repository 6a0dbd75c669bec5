// SPDX-License-Identifier: Apache-2.0
// What the plugin `gnss_range` brings.
#include "binnacle/plugin.hpp"

#include "clock_block.hpp"
#include "clock_process.hpp"
#include "earth_blocks.hpp"
#include "ecef_pv.hpp"
#include "geodetic_track.hpp"
#include "ned_antenna.hpp"
#include "ned_pv.hpp"
#include "pseudorange.hpp"
#include "range_rate.hpp"
#include "single_point.hpp"
#include "surveyed_point.hpp"

BINNACLE_TYPES(
    "ecef_position ecef_velocity receiver_clock clock_drift ecef_pv ned_pv pseudorange range_rate "
    "geodetic_position ned_velocity geodetic_track single_point surveyed_point");

BINNACLE_PLUGIN("gnss_range", "1.0.0", registry) {
  using namespace binnacle::gnss_range;
  registry.add<ClockBlock>();
  registry.add<EcefPosition>();
  registry.add<EcefVelocity>();
  registry.add<ClockProcess>();
  registry.add<EcefPv>();
  registry.add<NedPv>();
  registry.add<GeodeticPosition>();
  registry.add<NedVelocity>();
  registry.add<Pseudorange>();
  registry.add<RangeRateModel>();
  registry.add<SinglePoint>();
  registry.add<SurveyedPoint>();
  registry.add<GeodeticTrack>();
}
