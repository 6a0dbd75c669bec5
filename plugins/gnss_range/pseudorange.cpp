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
  spec.ports.push_back(reads("clock", "receiver_clock", "of the receiver"));
  spec.ports.push_back(
      may_read("galileo_bias", "vector:1:m", "what Galileo's pseudoranges have more than those of GPS"));
  spec.fields = gnss::observation_fields(true);
  spec.example = R"json({"channel": "gnss.obs", "inputs": {"ephemeris": "gnss.ephemeris", "iono": "gnss.iono"},
    "blocks": {"position": "antenna", "clock": "clock"}, "sigma": "0.5 m", "sigma_elevation": "0.5 m",
    "ionosphere": "klobuchar", "troposphere": "saastamoinen"})json";
  spec.surroundings = example_sky;
  return spec;
}

Pseudorange::Pseudorange(const Binding& binding)
    : RangeModel(binding),
      noise_(binding.parameters(), true),
      galileo_port_(binding.is_bound("galileo_bias") ? binding.port_index("galileo_bias") : -1) {
  declaration_.read_ports = {antenna_.port(), clock_port_};
  if (galileo_port_ >= 0) declaration_.read_ports.push_back(galileo_port_);
  declaration_.groups = {{"pseudorange", 0, 0, "m", -1}};
}

Result Pseudorange::linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                              const legacy::Context& /*context*/, std::byte* /*memory*/,
                              legacy::Linearization& out) const {
  gnss::AntennaPlace place;
  Sightings sightings;
  int count = 0;
  if (const Result result = sight(sample, auxiliary, x, place, sightings, count); !result) return result;
  out.rows = count;
  for (int i = 0; i < count; ++i) {
    const gnss::Sighting& s = sightings[static_cast<std::size_t>(i)];
    const bool has_galileo_bias =
        galileo_port_ >= 0 && gnss::constellation_of(s.satellite) == gnss::Constellation::galileo;
    const double system = has_galileo_bias ? x[galileo_port_][0] : 0.0;
    out.residual[i] = s.pseudorange - (s.path.range + x[clock_port_][0] + system + s.delay);
    const Eigen::RowVector3d by_ecef =
        -s.path.scale * s.path.direction.transpose() + s.d_delay_down * place.C_en.col(2).transpose();
    out.H[0].as<Eigen::Dynamic, 3>().row(i) = antenna_.by_error(place, by_ecef);
    out.H[1](i, 0) = 1;
    if (has_galileo_bias) out.H[2](i, 0) = 1;
    out.R(i, i) = noise_.variance(s);
    out.row_keys[i] = s.satellite;
  }
  return Result::ok();
}

}  // namespace binnacle::gnss_range
