// SPDX-License-Identifier: Apache-2.0
// The formats: each makes a file's text of a track.
#pragma once

#include "convert/convert.hpp"

namespace binnacle::convert {

/// What a format is given. `time` is there where it needs one.
struct Material {
  const results::RunResults& run;
  const results::FilterResults& filter;
  const Request& request;
  const Track& track;
  const std::optional<TimeBase>& time;
  std::string title;
};

std::string kml(const Material& material);
std::string gpx(const Material& material);
std::string pos(const Material& material);
std::string nmea(const Material& material);

/// Columns of `indices`, with `origin` for local axes.
std::string csv(const results::FilterResults& filter, const std::vector<std::size_t>& indices, const Request& request,
                const std::optional<TimeBase>& time, const std::optional<Place>& origin);
/// Whether any of its columns is of the calendar.
bool csv_needs_time(const Request& request);

}  // namespace binnacle::convert
