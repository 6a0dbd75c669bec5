// SPDX-License-Identifier: Apache-2.0
// The rows of an observation channel: what is measured, and what a channel may give of the satellite itself.
#include "gnss/observation_rows.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "gnss/channels.hpp"

namespace binnacle::gnss {

namespace {

RowField plain(observation::Field field) { return {field, observation::field_count, true}; }

FieldSpec optional(const char* name, const char* unit, const char* text) {
  return field::level(name, unit).per_row().optional().about(text);
}

/// All three, or none.
void bind_vector(const Binding& binding, const char* const (&names)[3], RowField (&fields)[3]) {
  int bound = 0;
  for (int i = 0; i < 3; ++i) {
    fields[i] = binding.row_field(names[i]);
    bound += fields[i].is_bound();
  }
  if (bound == 1 || bound == 2)
    throw ComponentError(std::string("the channel carries some of ") + names[0] + ", " + names[1] + ", " + names[2] +
                             ": all three, or none",
                         "/channel");
}

}  // namespace

std::vector<FieldSpec> given_fields() {
  return {
      optional("system", "1", "satellite system, as numbered by the source"),
      optional("satellite_x", "m", "ECEF position x of the satellite at transmission, instead of an ephemeris"),
      optional("satellite_y", "m", "ECEF position y of the satellite"),
      optional("satellite_z", "m", "ECEF position z of the satellite"),
      optional("satellite_vx", "m/s", "ECEF velocity x of the satellite, relative to the earth"),
      optional("satellite_vy", "m/s", "ECEF velocity y of the satellite"),
      optional("satellite_vz", "m/s", "ECEF velocity z of the satellite"),
      optional("satellite_clock", "s", "satellite time minus system time, if the pseudorange contains it"),
      optional("satellite_clock_drift", "1", "rate of the satellite clock offset, if the range rate contains it, s/s"),
      optional("pseudorange_sigma", "m", "standard deviation of the pseudorange; overrides the parameters"),
      optional("pseudorange_variance", "m^2", "variance of the pseudorange, instead of pseudorange_sigma"),
      optional("range_rate_sigma", "m/s", "standard deviation of the range rate; overrides the parameters"),
      optional("range_rate_variance", "m^2/s^2", "variance of the range rate, instead of range_rate_sigma"),
  };
}

ObservationRows::ObservationRows()
    : satellite_(plain(observation::satellite)),
      pseudorange_(plain(observation::pseudorange)),
      range_rate_(plain(observation::range_rate)),
      cn0_(plain(observation::cn0)) {}

ObservationRows::ObservationRows(const Binding& binding)
    : satellite_(binding.row_field("satellite")),
      pseudorange_(binding.row_field("pseudorange")),
      range_rate_(binding.row_field("range_rate")),
      cn0_(binding.row_field("cn0")),
      system_(binding.row_field("system")),
      clock_(binding.row_field("satellite_clock")),
      clock_drift_(binding.row_field("satellite_clock_drift")),
      range_sigma_(binding.row_field("pseudorange_sigma")),
      range_variance_(binding.row_field("pseudorange_variance")),
      rate_sigma_(binding.row_field("range_rate_sigma")),
      rate_variance_(binding.row_field("range_rate_variance")) {
  bind_vector(binding, {"satellite_x", "satellite_y", "satellite_z"}, position_);
  bind_vector(binding, {"satellite_vx", "satellite_vy", "satellite_vz"}, velocity_);
  if (!are_given() && (has_velocity() || has_system() || has_clock() || has_clock_drift()))
    throw ComponentError(
        "the channel carries a satellite's system, velocity or clock, but not its position: satellite_x, satellite_y, "
        "satellite_z",
        "/channel");
  if ((range_sigma_.is_bound() && range_variance_.is_bound()) || (rate_sigma_.is_bound() && rate_variance_.is_bound()))
    throw ComponentError("the channel carries a standard deviation and a variance of the same: one of them",
                         "/channel");
}

SatelliteKey ObservationRows::satellite(const SampleView& sample, int row) const {
  const double number = sample(row, satellite_);
  if (!are_given()) return satellite_key(number);
  if (!(number >= 0 && number < 1e6) || number != std::floor(number)) return 0;
  if (!has_system()) return static_cast<SatelliteKey>(number);
  const double system = sample(row, system_);
  if (!(system >= 0 && system < 1e6) || system != std::floor(system) || number >= 1000) return 0;
  return static_cast<SatelliteKey>(system) * 1000 + static_cast<SatelliteKey>(number);
}

std::int64_t ObservationRows::system(const SampleView& sample, int row, SatelliteKey key) const {
  return has_system() ? static_cast<std::int64_t>(sample(row, system_)) : key / 100;
}

double ObservationRows::variance(const SampleView& sample, int row, RowField sigma, RowField variance) {
  if (variance.is_bound()) return sample(row, variance);
  if (!sigma.is_bound()) return std::numeric_limits<double>::quiet_NaN();
  const double s = sample(row, sigma);
  return s > 0 ? s * s : s;  // one that is not positive stays so, and the row is refused
}

}  // namespace binnacle::gnss
