// SPDX-License-Identifier: Apache-2.0
// export: what a run left in a folder as a file of another program.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <memory>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "binnacle/unit.hpp"
#include "convert/convert.hpp"
#include "output.hpp"
#include "results_folder.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

struct ExportVerbOptions {
  std::string folder, format, output, rate, geoid_separation, origin;
  std::int64_t week = -1, leap_seconds = -1, every = 1;
  convert::Request request;
  bool json = false;
};

/// "49.01,8.43,115": degrees, and metres above the ellipsoid.
convert::Place place_of(const std::string& text) {
  std::vector<std::string> words{""};
  for (const char c : text)
    if (c == ',')
      words.emplace_back();
    else
      words.back() += c;
  if (words.size() != 3)
    throw UsageError(fmt::format("--origin takes LAT,LON,HEIGHT in degrees and metres; found '{}'", text));
  const auto number = [&](std::size_t i, double most) {
    const auto parsed = parse_quantity(words[i]);
    if (!parsed || !parsed->dimension.is_dimensionless() || !(std::abs(parsed->value) <= most))
      throw UsageError(
          fmt::format("--origin takes LAT,LON,HEIGHT in degrees and metres; '{}' is none of these", words[i]));
    return parsed->value;
  };
  constexpr double degree = 3.14159265358979323846 / 180;
  return {number(0, 90) * degree, number(1, 360) * degree, number(2, 1e9), "--origin"};
}

void read_options(ExportVerbOptions& options) {
  auto& request = options.request;
  const auto* const found =
      std::find(std::begin(convert::format_names), std::end(convert::format_names), options.format);
  request.format = static_cast<convert::Format>(found - std::begin(convert::format_names));
  if (options.every < 1) throw UsageError(fmt::format("--every takes 1 or more; found {}", options.every));
  request.every = static_cast<std::size_t>(options.every);
  if (!options.rate.empty()) {
    request.rate = quantity("--rate", options.rate, "Hz");
    if (!(request.rate > 0)) throw UsageError(fmt::format("--rate takes a rate above 0; found '{}'", options.rate));
  }
  if (!options.geoid_separation.empty())
    request.geoid_separation = quantity("--geoid-separation", options.geoid_separation, "m");
  if (!options.origin.empty()) request.origin = place_of(options.origin);
  if (options.week >= 0) request.time.week = options.week;
  if (options.leap_seconds >= 0) request.time.leap_seconds = options.leap_seconds;
}

/// DIR/FILTER.kml. What `run` writes by that name, DIR/FILTER.csv, is another file.
fs::path default_file(const ExportVerbOptions& options, const std::string& filter) {
  return fs::path(options.folder) / (filter + (options.format == "csv" ? ".export.csv" : "." + options.format));
}

/// The results themselves stay.
void guard_results(const ExportVerbOptions& options, const results::RunResults& run, const fs::path& file) {
  std::vector<std::string> names{"run.nc", "summary.json", "config.json", "study.nc", "study.json", "report.html"};
  for (const auto& filter : run.filters) names.push_back(filter.name + ".csv");
  std::error_code ignored;
  for (const auto& name : names)
    if (fs::equivalent(file, fs::path(options.folder) / name, ignored))
      throw UsageError(
          fmt::format("'{}' is one of the results that are exported; --output takes another", file.string()));
}

Json time_json(const std::optional<convert::TimeBase>& time) {
  return time ? Json{{"base", time->text}, {"from", time->from}} : Json(nullptr);
}

Json origin_json(const std::optional<convert::Place>& origin) {
  constexpr double degree = 3.14159265358979323846 / 180;
  return origin ? Json{{"lat", origin->lat / degree},
                       {"lon", origin->lon / degree},
                       {"height", origin->height},
                       {"from", origin->from}}
                : Json(nullptr);
}

void show(const ExportVerbOptions& options, const fs::path& file, const convert::Result& result) {
  if (options.json) {
    print_json({{"file", file.string()},
                {"format", options.format},
                {"bytes", result.text.size()},
                {"filter", result.filter},
                {"block", result.block.empty() ? Json(nullptr) : Json(result.block)},
                {"records", result.records},
                {"left_out", result.left_out},
                {"of", result.of},
                {"from_s", result.from_s},
                {"to_s", result.to_s},
                {"time", time_json(result.time)},
                {"origin", origin_json(result.origin)},
                {"notes", result.notes}});
    return;
  }
  if (file != "/dev/stdout") {
    print(fmt::format("{}: {} of filter '{}', of {}\n", file.string(), counted(result.records, "record"), result.filter,
                      result.of));
    if (result.time) print(fmt::format("  time: {} ({})\n", result.time->text, result.time->from));
    if (result.origin)
      print(fmt::format("  origin: {:.9f} deg, {:.9f} deg, {:.3f} m ({})\n", result.origin->lat * 57.29577951308232,
                        result.origin->lon * 57.29577951308232, result.origin->height, result.origin->from));
  }
  flush_stdout();
  for (const auto& note : result.notes) print_note(note);
}

int export_results(ExportVerbOptions& options) {
  read_options(options);
  const results::RunResults run = read_run(options.folder);
  convert::Result result;
  try {
    result = convert::convert(run, options.request);
  } catch (const convert::NoData& nothing) {
    throw OutputError(fmt::format("'{}': {}", options.folder, nothing.what()));
  } catch (const convert::Refusal& refusal) {
    throw UsageError(refusal.what());
  }
  const fs::path path = options.output.empty() ? default_file(options, result.filter) : fs::path(options.output);
  guard_results(options, run, path);
  AtomicFile file(path);
  file.write(result.text);
  file.commit();
  show(options, path, result);
  return ok;
}

void add_options(CLI::App& app, ExportVerbOptions& options) {
  app.add_option("DIR", options.folder, "Folder of --out of run")->required();
  app.add_option("--to", options.format, "Format: kml, gpx, pos (RTKLIB), nmea or csv")
      ->required()
      ->type_name("FORMAT")
      ->check(CLI::IsMember({"kml", "gpx", "pos", "nmea", "csv"}));
  app.add_option("-o,--output", options.output, "Output file, instead of DIR/FILTER.FORMAT")->type_name("FILE");
  app.add_option("--filter", options.request.filter, "Filter, if there are several")->type_name("NAME");
  app.add_option("--rate", options.rate, "Largest number of records per second: 1, \"10 Hz\"")->type_name("RATE");
  app.add_option("--every", options.every, "Write every n-th record")->type_name("N");
  app.add_option("--columns", options.request.columns,
                 "csv: columns, separated by commas: utc, BLOCK, BLOCK.OUTPUT, BLOCK.OUTPUT.sigma")
      ->type_name("NAMES")
      ->delimiter(',');
  app.add_flag("--local", options.request.is_local,
               "csv: position in metres north, east, down of --origin, the config's origin or the first record");
  app.add_option("--origin", options.origin, "Origin of the local axes, in degrees and metres above the ellipsoid")
      ->type_name("LAT,LON,HEIGHT");
  app.add_flag("--colour", options.request.is_coloured,
               "kml: colour the track by the horizontal 1-sigma of the filter");
  app.add_option("--geoid-separation", options.geoid_separation,
                 "Height of the geoid above the ellipsoid, for heights above sea level in kml, gpx and nmea")
      ->type_name("M");
  app.add_option("--week", options.week,
                 "GPS week at whose start the time of the data is zero, in GPS time; 0: 1980-01-06")
      ->type_name("N")
      ->check(CLI::Range(0, 9999));
  app.add_option("--epoch", options.request.time.epoch, "Instant at which the time of the data is zero, in UTC")
      ->type_name("INSTANT");
  app.add_option("--leap-seconds", options.leap_seconds, "GPS time minus UTC, instead of the value for the date")
      ->type_name("S")
      ->check(CLI::Range(0, 100));
  app.add_flag("--json", options.json, "Print the file name and its contents as JSON on stdout");
}

}  // namespace

Verb export_verb(CLI::App& command) {
  const auto options = std::make_shared<ExportVerbOptions>();
  CLI::App* app = add_verb(command, "export");
  add_options(*app, *options);
  return {app, [options] { return export_results(*options); }};
}

}  // namespace binnacle::command
