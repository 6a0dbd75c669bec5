// SPDX-License-Identifier: Apache-2.0
// A filter's estimates in the formats of other programs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "convert/time_base.hpp"
#include "convert/track.hpp"

namespace binnacle::convert {

enum class Format { kml, gpx, pos, nmea, csv };
/// Also the endings of files.
inline constexpr const char* format_names[] = {"kml", "gpx", "pos", "nmea", "csv"};

struct Request {
  Format format = Format::kml;
  std::string filter;                      // empty: the only one
  std::size_t every = 1;                   // each n-th record
  double rate = 0;                         // no more than so many records a second; 0: all
  bool is_local = false;                   // csv: positions as north, east, down [m]
  bool is_coloured = false;                // kml: by the horizontal sigma
  std::vector<std::string> columns;        // csv; empty: all outputs
  std::optional<double> geoid_separation;  // height of the geoid above the ellipsoid [m]
  std::optional<Place> origin;             // before that of the config
  GivenTime time;
};

struct Result {
  std::string text;  // the file
  std::string filter, block;
  std::size_t records = 0, left_out = 0, of = 0;
  double from_s = 0, to_s = 0;     // channels' clock
  std::optional<TimeBase> time;    // nothing: not known, or of no matter
  std::optional<Place> origin;     // of local axes
  std::vector<std::string> notes;  // what the file does not have, and what to do
};

/// Throws Refusal.
Result convert(const results::RunResults& run, const Request& request);

}  // namespace binnacle::convert
