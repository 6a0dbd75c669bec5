// SPDX-License-Identifier: Apache-2.0
// The channels that carry GNSS data: their fields, and rows to and from messages. A source that fills them, recorded or
// simulated, fits every component that reads them.
#pragma once

#include <vector>

#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"
#include "gnss/atmosphere.hpp"
#include "gnss/orbit.hpp"

namespace binnacle::gnss {

/// Rows of an observation channel, in this order; all but the first two are NaN where the receiver gives none.
namespace observation {
enum Field { satellite, pseudorange, range_rate, cn0, field_count };
}

/// Per satellite: satellite [key], pseudorange [m], range_rate [m/s], cn0 [dB-Hz].
/// optional_rate: for a component that does without range_rate (and cn0, which is always optional).
std::vector<FieldSpec> observation_fields(bool rate_is_optional);
/// Per satellite, in this order: satellite [key], and the members of Ephemeris.
std::vector<FieldSpec> ephemeris_fields();
/// a0 … a3, b0 … b3.
std::vector<FieldSpec> klobuchar_fields();

inline constexpr int ephemeris_field_count = 24;

void write_ephemeris(const Ephemeris& ephemeris, double* row);
Ephemeris read_ephemeris(const double* row);
Klobuchar read_klobuchar(const double* fields);

/// The row of a satellite in a sample of an ephemeris channel; null where there is none.
const double* find_ephemeris(const SampleView& ephemerides, SatelliteKey satellite);

/// "ephemeris" and "iono", as a component subscribes to them.
ChannelPort ephemeris_port();
ChannelPort klobuchar_port();

}  // namespace binnacle::gnss
