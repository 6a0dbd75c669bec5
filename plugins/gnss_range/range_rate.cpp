// SPDX-License-Identifier: Apache-2.0
// Range rates: a row for each satellite of an epoch that has one.
#include "range_rate.hpp"

#include <cmath>

#include "example_sky.hpp"

namespace binnacle::gnss_range {

ComponentSpec RangeRateModel::spec() {
  ComponentSpec spec;
  spec.type = "range_rate";
  spec.summary =
      "Range rates (Doppler shifts) of satellites, from broadcast ephemerides or given satellite velocities, a row for "
      "each.";
  spec.source = "paper 003, equations (7) to (10); IS-GPS-200 20.3.3";
  spec.parameters = gnss::RangeNoise::parameters(gnss::RangeNoise::Of::range_rate, "\"0.1 m/s\"");
  describe_range_model(spec, false);
  spec.ports = position_ports();
  for (auto& port : velocity_ports()) spec.ports.push_back(std::move(port));
  spec.ports.push_back(reads("clock", "receiver_clock").about("clock of the receiver"));
  spec.example = R"json({"channel": "gnss.obs", "inputs": {"ephemeris": "gnss.ephemeris"},
    "blocks": {"position": "antenna", "velocity": "antenna_velocity", "clock": "clock"}, "sigma": "0.05 m/s"})json";
  spec.surroundings = example_sky;
  return spec;
}

RangeRateModel::RangeRateModel(const Binding& binding)
    : RangeModel(binding, gnss::RangeNoise::Of::range_rate), velocity_(binding) {
  if (rows_.are_given() && !rows_.has_velocity())
    throw ComponentError(
        "the channel gives the satellites' positions, but not their velocities: satellite_vx, "
        "satellite_vy, satellite_vz",
        "/channel");
  declaration_.reads(velocity_.port()).reads(clock_).group(rows::like("range_rate", "m/s"));
}

Result RangeRateModel::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  gnss::AntennaPlace place;
  Sightings sightings;
  int count = 0;
  if (const Result result = sight(in, place, sightings, count); !result) return result;
  const Eigen::Vector3d v_e = velocity_.read(in.x, place);
  if (!(v_e.cwiseAbs().maxCoeff() < 1e5)) return Result::unsupported("the antenna is faster than any vehicle");
  const double clock_drift = in.x[clock_][1];
  int rows = 0;
  for (int i = 0; i < count; ++i) {
    const gnss::Sighting& s = sightings[static_cast<std::size_t>(i)];
    if (!(std::abs(s.range_rate) < 1e6)) continue;  // NaN: none was measured
    if (!(s.velocity.norm() < 1e5)) {               // NaN as well
      in.notes.leave("a row is left out: its satellite has no valid velocity");
      continue;
    }
    const gnss::RangeRate predicted = gnss::range_rate(s.path, s.velocity, v_e, corrections_.has_rotation());
    out.residual[rows] = s.range_rate - (predicted.rate + clock_drift + s.rate_delay);
    if (out.H) {
      out.H[antenna_.port()].as().row(rows) =
          antenna_.by_error(place, predicted.by_position + velocity_.by_position(in.x, place, predicted.by_velocity));
      out.H[velocity_.port()].as().row(rows) = velocity_.by_error(place, predicted.by_velocity);
      out.H[clock_](rows, 1) = 1;
    }
    out.R(rows, rows) = noise_.variance(s);
    out.row_keys[static_cast<std::size_t>(rows)] = s.satellite;
    ++rows;
  }
  out.rows = rows;  // none: in a stack the pseudoranges of the epoch count all the same
  return Result::ok();
}

}  // namespace binnacle::gnss_range
