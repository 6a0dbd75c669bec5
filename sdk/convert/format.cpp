// SPDX-License-Identifier: Apache-2.0
#include "format.hpp"

#include <algorithm>
#include <cmath>

#include "local_frame.hpp"

namespace binnacle::convert {

namespace {

using results::FilterResults;
using results::RunResults;

std::string names_of(const RunResults& run) {
  std::string names;
  for (const auto& filter : run.filters) names += (names.empty() ? "'" : ", '") + filter.name + "'";
  return names;
}

const FilterResults& filter_of(const RunResults& run, const std::string& name) {
  if (run.filters.empty()) throw NoData("the run has no filter");
  if (name.empty()) {
    if (run.filters.size() > 1)
      throw Refusal("the run has several filters; --filter chooses one of them: " + names_of(run));
    return run.filters.front();
  }
  for (const auto& filter : run.filters)
    if (filter.name == name) return filter;
  throw Refusal("the run has no filter '" + name + "'; it has " + names_of(run));
}

std::string title_of(const RunResults& run) {
  const auto title = run.config.find("title");
  return title != run.config.end() && title->is_string() ? title->get<std::string>() : "";
}

constexpr const char* how_time =
    "the run does not give the origin of its time; --week N (GPS time from the start of a week, 0: since 1980-01-06) "
    "or --epoch 2026-11-23T12:00:00Z (UTC) does";

void check_options(const Request& request) {
  const char* const name = format_names[static_cast<int>(request.format)];
  const auto refuse = [&](const char* option, const char* of) {
    throw Refusal(std::string(option) + " is of " + of + "; " + name + " has no such thing");
  };
  if (request.is_local && request.format != Format::csv) refuse("--local", "--to csv");
  if (!request.columns.empty() && request.format != Format::csv) refuse("--columns", "--to csv");
  if (request.is_coloured && request.format != Format::kml) refuse("--colour", "--to kml");
  if (request.geoid_separation && (request.format == Format::pos || request.format == Format::csv))
    refuse("--geoid-separation", "--to kml, gpx and nmea");
  if (request.every < 1) throw Refusal("--every takes 1 or more");
  if (!(request.rate >= 0)) throw Refusal("--rate takes a frequency above 0");
}

void add_notes(const Request& request, const Track& track, Result& result) {
  const char* const name = format_names[static_cast<int>(request.format)];
  if (!result.time) result.notes.push_back(std::string("the file has no times: ") + how_time);
  const bool has_height = track.has_vertical && request.geoid_separation;
  if (request.format != Format::pos && !has_height)
    result.notes.push_back(track.has_vertical
                               ? std::string("the file has no heights: ") + name +
                                     " needs heights above sea level, but the run has heights above the ellipsoid; "
                                     "--geoid-separation M (height of the geoid above the ellipsoid) converts them"
                               : std::string("the file has no heights: the filter estimates none"));
  if (request.format == Format::pos && !track.has_vertical)
    result.notes.push_back("the filter estimates no height: it is that of the origin's plane");
}

void add_records(const FilterResults& filter, std::size_t records, std::size_t left_out, Result& result) {
  result.records = records;
  result.left_out = left_out;
  result.of = filter.t.size();
  if (left_out > 0)
    result.notes.push_back(std::to_string(left_out) + (left_out == 1 ? " record is" : " records are") +
                           " left out: the position is not finite");
}

Result converted_csv(const RunResults& run, const FilterResults& filter, const std::vector<std::size_t>& indices,
                     const Request& request, Result result) {
  if (csv_needs_time(request) && !result.time) throw Refusal(std::string("column 'utc': ") + how_time);
  if (request.is_local) {
    std::optional<Place> origin = request.origin ? request.origin : origin_of(run.config);
    const Track track = track_of(filter, indices, origin);
    if (!origin) {
      if (track.records.empty()) throw NoData("filter '" + filter.name + "' has no position that is finite");
      const Record& first = track.records.front();
      origin = Place{first.lat, first.lon, std::isfinite(first.height) ? first.height : 0, "the first record"};
    }
    result.block = track.block;
    result.origin = origin;
  }
  if (!csv_needs_time(request)) result.time.reset();
  result.text = csv(filter, indices, request, result.time, result.origin);
  add_records(filter, indices.size(), 0, result);
  return result;
}

}  // namespace

Result convert(const RunResults& run, const Request& request) {
  check_options(request);
  const FilterResults& filter = filter_of(run, request.filter);
  if (filter.t.empty())
    throw NoData("filter '" + filter.name + "' has no estimates: it never started, or nothing of it was recorded");
  const auto t = times_of(filter);
  const auto indices = chosen(t, request.every, request.rate);
  Result result;
  result.filter = filter.name;
  result.from_s = filter.t[indices.front()];
  result.to_s = filter.t[indices.back()];
  result.time = time_base(run.config, request.time, t[indices.front()]);
  if (request.format == Format::csv) return converted_csv(run, filter, indices, request, std::move(result));
  const std::optional<Place> origin = request.origin ? request.origin : origin_of(run.config);
  const Track track = track_of(filter, indices, origin);
  if (track.records.empty()) throw NoData("filter '" + filter.name + "' has no position that is finite");
  result.block = track.block;
  if (track.kind == PositionKind::local) result.origin = origin;
  const bool needs_time = request.format == Format::pos || request.format == Format::nmea;
  if (needs_time && !result.time)
    throw Refusal(std::string(format_names[static_cast<int>(request.format)]) +
                  " is nothing without times: " + how_time);
  const Material material{run, filter, request, track, result.time, title_of(run)};
  switch (request.format) {
    case Format::kml: result.text = kml(material); break;
    case Format::gpx: result.text = gpx(material); break;
    case Format::pos: result.text = pos(material); break;
    default: result.text = nmea(material);
  }
  add_records(filter, track.records.size(), track.left_out, result);
  add_notes(request, track, result);
  return result;
}

}  // namespace binnacle::convert
