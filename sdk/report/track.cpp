// SPDX-License-Identifier: Apache-2.0
#include "track.hpp"

#include <algorithm>
#include <cmath>

#include "missing.hpp"

namespace binnacle::report {

namespace {

using results::Error;
using results::Estimate;
using results::FilterResults;

struct Radii {
  double meridian, transverse;  // [m]
};

/// WGS 84 (NIMA TR8350.2, section 4).
Radii radii(double lat) {
  constexpr double a = 6378137.0, e2 = 6.69437999014e-3;
  const double w2 = 1 - e2 * std::sin(lat) * std::sin(lat);
  return {a * (1 - e2) / (w2 * std::sqrt(w2)), a / std::sqrt(w2)};
}

const Estimate* output(const FilterResults& filter, const std::string& block, const std::string& name) {
  for (const auto& estimate : filter.estimates)
    if (estimate.block == block && estimate.output == name) return &estimate;
  return nullptr;
}

const Error* error(const FilterResults& filter, const std::string& name) {
  for (const auto& entry : filter.errors)
    if (entry.name == name) return &entry;
  return nullptr;
}

double first_finite(const std::vector<double>& values) {
  for (const double value : values)
    if (std::isfinite(value)) return value;
  return not_a_number;
}

std::vector<double> horizontal_sigma(const Estimate& north, const Estimate& east, double metres_north,
                                     double metres_east) {
  const auto n = std::min(north.sigma.size(), east.sigma.size());
  std::vector<double> sigma(n);
  for (std::size_t i = 0; i < n; ++i) sigma[i] = std::hypot(north.sigma[i] * metres_north, east.sigma[i] * metres_east);
  return sigma;
}

/// Where the estimate was at t; nothing outside of its times.
std::optional<std::pair<double, double>> at(const Path& path, double t) {
  const auto after = std::lower_bound(path.t.begin(), path.t.end(), t);
  if (after == path.t.end()) return std::nullopt;
  const auto i = static_cast<std::size_t>(after - path.t.begin());
  if (*after == t) return std::pair{path.east[i], path.north[i]};
  if (i == 0) return std::nullopt;
  const double share = (t - path.t[i - 1]) / (path.t[i] - path.t[i - 1]);
  return std::pair{std::lerp(path.east[i - 1], path.east[i], share),
                   std::lerp(path.north[i - 1], path.north[i], share)};
}

void add_reference(const FilterResults& filter, Track& track) {
  const Error* north = error(filter, track.block + ".north");
  const Error* east = error(filter, track.block + ".east");
  if (!north || !east || north->t != east->t) return;
  for (std::size_t i = 0; i < north->t.size(); ++i) {
    const auto place = at(track.estimate, north->t[i]);
    if (!place) continue;
    track.reference.t.push_back(north->t[i]);
    track.reference.east.push_back(place->first + east->values[i]);
    track.reference.north.push_back(place->second + north->values[i]);
    track.error.push_back(std::hypot(north->values[i], east->values[i]));
  }
}

Track geographic(const FilterResults& filter, const Estimate& lat, const Estimate& lon,
                 const std::optional<TrackOrigin>& origin) {
  Track track{lat.block, first_finite(lat.values), first_finite(lon.values), {filter.t, {}, {}}, {}, {}, {}};
  if (origin) track.lat = origin->lat, track.lon = origin->lon;
  const Radii earth = radii(track.lat);
  const double metres_east = earth.transverse * std::cos(track.lat);
  for (std::size_t i = 0; i < filter.t.size(); ++i) {
    track.estimate.north.push_back((lat.values[i] - track.lat) * earth.meridian);
    track.estimate.east.push_back(std::remainder(lon.values[i] - track.lon, 2 * M_PI) * metres_east);
  }
  track.sigma = horizontal_sigma(lat, lon, earth.meridian, metres_east);
  return track;
}

Track plane(const FilterResults& filter, const Estimate& north, const Estimate& east) {
  return {north.block,
          not_a_number,
          not_a_number,
          {filter.t, east.values, north.values},
          horizontal_sigma(north, east, 1, 1),
          {},
          {}};
}

}  // namespace

std::optional<Track> track_of(const FilterResults& filter, const std::optional<TrackOrigin>& origin) {
  std::optional<Track> track;
  for (const auto& estimate : filter.estimates) {
    if (estimate.output == "lat" && estimate.unit == "rad") {
      if (const auto* lon = output(filter, estimate.block, "lon")) track = geographic(filter, estimate, *lon, origin);
    } else if (estimate.output == "north" && estimate.unit == "m") {
      if (const auto* east = output(filter, estimate.block, "east")) track = plane(filter, estimate, *east);
    }
    if (track) break;
  }
  if (track) add_reference(filter, *track);
  return track;
}

}  // namespace binnacle::report
