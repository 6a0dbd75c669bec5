// SPDX-License-Identifier: Apache-2.0
// Pseudoranges: a row for each satellite of an epoch.
#include "pseudorange.hpp"

#include "example_sky.hpp"

namespace binnacle::gnss_range {

ComponentSpec Pseudorange::spec() {
  ComponentSpec spec;
  spec.type = "pseudorange";
  spec.summary = "Pseudoranges to satellites with a broadcast ephemeris, a row for each.";
  spec.source = "paper 003, equations (5), (6), (10); IS-GPS-200 20.3.3";
  spec.parameters = gnss::ElevationNoise::parameters("m", true, "\"5 m\"");
  describe_range_model(spec);
  spec.ports = position_ports();
  spec.ports.push_back(reads("clock", "receiver_clock").about("of the receiver"));
  spec.ports.push_back(
      reads("galileo_bias", "vector:1:m").optional().about("what Galileo's pseudoranges have more than those of GPS"));
  spec.fields = gnss::observation_fields(true);
  spec.example = R"json({"channel": "gnss.obs", "inputs": {"ephemeris": "gnss.ephemeris", "iono": "gnss.iono"},
    "blocks": {"position": "antenna", "clock": "clock"}, "sigma": "0.5 m", "sigma_elevation": "0.5 m",
    "ionosphere": "klobuchar", "troposphere": "saastamoinen"})json";
  spec.surroundings = example_sky;
  return spec;
}

Pseudorange::Pseudorange(const Binding& binding)
    : RangeModel(binding), noise_(binding.parameters(), true), galileo_bias_(binding.port("galileo_bias")) {
  declaration_.reads(clock_).reads(galileo_bias_).group(rows::like("pseudorange", "m"));
}

Result Pseudorange::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  gnss::AntennaPlace place;
  Sightings sightings;
  int count = 0;
  if (const Result result = sight(in, place, sightings, count); !result) return result;
  out.rows = count;
  const double clock_bias = in.x[clock_][0];
  const MatrixView by_position = out.H[antenna_.port()], by_clock = out.H[clock_], by_galileo = out.H[galileo_bias_];
  for (int i = 0; i < count; ++i) {
    const gnss::Sighting& s = sightings[static_cast<std::size_t>(i)];
    const bool has_galileo_bias =
        galileo_bias_.is_bound() && gnss::constellation_of(s.satellite) == gnss::Constellation::galileo;
    const double system = has_galileo_bias ? in.x[galileo_bias_][0] : 0.0;
    out.residual[i] = s.pseudorange - (s.path.range + clock_bias + system + s.delay);
    out.R(i, i) = noise_.variance(s);
    out.row_keys[static_cast<std::size_t>(i)] = s.satellite;
    if (!out.H) continue;
    const Eigen::RowVector3d by_ecef =
        -s.path.scale * s.path.direction.transpose() + s.d_delay_down * place.C_en.col(2).transpose();
    by_position.as().row(i) = antenna_.by_error(place, by_ecef);
    by_clock(i, 0) = 1;
    if (has_galileo_bias) by_galileo(i, 0) = 1;
  }
  return Result::ok();
}

}  // namespace binnacle::gnss_range
