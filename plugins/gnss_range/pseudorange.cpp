// SPDX-License-Identifier: Apache-2.0
// Pseudoranges: a row for each satellite of an epoch.
#include "pseudorange.hpp"

#include <string>

#include "example_sky.hpp"

namespace binnacle::gnss_range {

ComponentSpec Pseudorange::spec() {
  ComponentSpec spec;
  spec.type = "pseudorange";
  spec.summary = "Pseudoranges to satellites, from broadcast ephemerides or given satellite positions, a row for each.";
  spec.source = "paper 003, equations (5), (6), (10); IS-GPS-200 20.3.3";
  spec.parameters = gnss::RangeNoise::parameters(gnss::RangeNoise::Of::pseudorange, "\"5 m\"");
  describe_range_model(spec, true);
  spec.ports = position_ports();
  spec.ports.push_back(reads("clock", "receiver_clock").about("clock of the receiver"));
  spec.ports.push_back(
      reads("system_offset", "vector:*:m")
          .optional()
          .formerly("galileo_bias")
          .about("inter-system offset of the pseudoranges of each of 'systems' after the first, relative to the first; "
                 "without 'systems': of Galileo relative to GPS, and BeiDou is not used"));
  spec.example = R"json({"channel": "gnss.obs", "inputs": {"ephemeris": "gnss.ephemeris", "iono": "gnss.iono"},
    "blocks": {"position": "antenna", "clock": "clock"}, "sigma": "0.5 m", "sigma_elevation": "0.5 m",
    "ionosphere": "klobuchar", "troposphere": "saastamoinen"})json";
  spec.surroundings = example_sky;
  return spec;
}

Pseudorange::Pseudorange(const Binding& binding)
    : RangeModel(binding, gnss::RangeNoise::Of::pseudorange), system_offset_(binding.port("system_offset")) {
  if (system_offset_.is_bound() && !has_systems() && !rows_.are_given()) systems_ = {1, 2};
  const int others = static_cast<int>(systems_.size()) - 1;
  if (system_offset_.is_bound() && system_offset_.dof() != others)
    throw ComponentError(others < 0
                             ? std::string("list the 'systems' that the offsets are of")
                             : "its block has " + std::to_string(system_offset_.dof()) +
                                   " components where 'systems' lists " + std::to_string(others) + " besides the first",
                         "/blocks/system_offset");
  if (!system_offset_.is_bound() && others > 0)
    binding.note("several satellite systems share one clock: no block is plugged into 'system_offset'");
  declaration_.reads(clock_).reads(system_offset_).group(rows::like("pseudorange", "m"));
}

Result Pseudorange::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  gnss::AntennaPlace place;
  Sightings sightings;
  int count = 0;
  if (const Result result = sight(in, place, sightings, count); !result) return result;
  out.rows = count;
  const double clock_bias = in.x[clock_][0];
  const MatrixView by_position = out.H[antenna_.port()], by_clock = out.H[clock_], by_offset = out.H[system_offset_];
  for (int i = 0; i < count; ++i) {
    const gnss::Sighting& s = sightings[static_cast<std::size_t>(i)];
    const int offset = system_offset_.is_bound() ? system_of(s) - 1 : -1;  // −1: on the receiver's own clock
    const double system = offset >= 0 ? in.x[system_offset_][offset] : 0.0;
    out.residual[i] = s.pseudorange - (s.path.range + clock_bias + system + s.delay);
    out.R(i, i) = noise_.variance(s);
    out.row_keys[static_cast<std::size_t>(i)] = s.satellite;
    if (!out.H) continue;
    const Eigen::RowVector3d by_ecef =
        -s.path.scale * s.path.direction.transpose() + s.d_delay_down * place.C_en.col(2).transpose();
    by_position.as().row(i) = antenna_.by_error(place, by_ecef);
    by_clock(i, 0) = 1;
    if (offset >= 0) by_offset(i, offset) = 1;
  }
  return Result::ok();
}

}  // namespace binnacle::gnss_range
