// SPDX-License-Identifier: Apache-2.0
// The formats: what other programs read of them is what the run had.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numbers>
#include <regex>
#include <sstream>

#include <unistd.h>
#include <GeographicLib/LocalCartesian.hpp>

#include "../readers/reading.hpp"
#include "catch.hpp"
#include "convert/convert.hpp"
#include "rtklib/pos_source.hpp"
#include "skip.hpp"

namespace formats_test {

using namespace binnacle;
using namespace binnacle::test;
using convert::Format;
using convert::Request;
using nlohmann::json;
using results::FilterResults;
using results::RunResults;

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr double lat0 = -33.9 * degree, lon0 = 151.2 * degree, height0 = 60;

bool has(const std::string& program) {
  return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
}

/// South and east of the earth, so that no sign is right by chance: moves to the north-east, climbs, and turns.
FilterResults drive(const std::string& name, std::size_t n, double step) {
  FilterResults filter;
  filter.name = name;
  const auto add = [&](const char* block, const char* output, const char* unit, const char* kind, auto value,
                       double sigma) {
    results::Estimate estimate{block, output, unit, "", false, {}, {}, kind};
    for (std::size_t i = 0; i < n; ++i) {
      estimate.values.push_back(value(static_cast<double>(i)));
      estimate.sigma.push_back(sigma * (1 + static_cast<double>(i) / 10));
    }
    filter.estimates.push_back(std::move(estimate));
  };
  for (std::size_t i = 0; i < n; ++i) filter.t.push_back(100 + step * static_cast<double>(i));
  add(
      "position", "lat", "rad", "position", [](double i) { return lat0 + 2e-6 * i; }, 1e-7);
  add(
      "position", "lon", "rad", "position", [](double i) { return lon0 + 3e-6 * i; }, 2e-7);
  add(
      "position", "height", "m", "position", [](double i) { return height0 + 0.5 * i; }, 1.5);
  add(
      "velocity", "vn", "m/s", "velocity.ned", [](double i) { return 12 + 0.1 * i; }, 0.1);
  add(
      "velocity", "ve", "m/s", "velocity.ned", [](double i) { return 15 - 0.2 * i; }, 0.2);
  add(
      "velocity", "vd", "m/s", "velocity.ned", [](double i) { return -0.5 - 0.01 * i; }, 0.3);
  add(
      "attitude", "yaw", "rad", "attitude", [](double i) { return 0.9 - 0.01 * i; }, 0.01);
  return filter;
}

RunResults run_of(std::vector<FilterResults> filters, const char* config) {
  RunResults run;
  run.config = results::Json::parse(config);
  run.provenance = {{"version", "1.2.3"}};
  run.filters = std::move(filters);
  return run;
}

const char* const of_week =
    R"({"title": "a <drive> & \"more\"", "sources": {"gnss": {"type": "ublox", "path": "x", "week": 2381}}})";

RunResults one_drive() { return run_of({drive("ins", 50, 0.2)}, of_week); }

convert::Result made(const RunResults& run, Format format, const std::function<void(Request&)>& change = {}) {
  Request request;
  request.format = format;
  if (change) change(request);
  return convert::convert(run, request);
}

std::string refusal(const RunResults& run, Format format, const std::function<void(Request&)>& change = {}) {
  try {
    made(run, format, change);
  } catch (const convert::Refusal& refused) {
    return refused.what();
  }
  return {};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<std::smatch> all_matches(const std::string& text, const std::regex& pattern) {
  return {std::sregex_iterator(text.begin(), text.end(), pattern), {}};
}

const double& value(const RunResults& run, std::size_t output, std::size_t i) {
  return run.filters[0].estimates[output].values[i];
}

void require_well_formed(const Folder& folder, const std::string& name, const std::string& text) {
  if (!has("xmllint")) return skip("no xmllint (Debian package libxml2-utils)");
  const std::string file = folder.write(name, text);
  REQUIRE(std::system(("xmllint --noout --nonet '" + file + "'").c_str()) == 0);
}

/// 100 s after the begin of GPS week 2381, 2025-08-24, 18 leap seconds taken off.
const char* const first_time = "2025-08-24T00:01:22.000Z";

}  // namespace

TEST_CASE("of many records every n-th is chosen, and no more than the rate") {
  std::vector<Time> t;
  for (Time i = 0; i < 1000; ++i) t.push_back(5'000'000'000 + i * 10'000'000);  // 100 Hz
  CHECK(convert::chosen(t, 1, 0).size() == 1000);
  CHECK(convert::chosen(t, 3, 0) == convert::chosen(t, 3, 1000));
  CHECK(convert::chosen(t, 3, 0)[2] == 6);
  const auto at_1_hz = convert::chosen(t, 1, 1);
  REQUIRE(at_1_hz.size() == 10);
  for (std::size_t i = 0; i < 10; ++i) CHECK(at_1_hz[i] == 100 * i);
  // A period of three records and a third: no drift, no record twice.
  const auto at_30_hz = convert::chosen(t, 1, 30);
  REQUIRE(at_30_hz.size() == 300);
  CHECK(at_30_hz[299] == 997);
  // A hole of two seconds begins no burst.
  t.erase(t.begin() + 100, t.begin() + 300);
  CHECK(convert::chosen(t, 1, 1).size() == 8);
}

TEST_CASE("KML is well-formed, in the order longitude, latitude, and in UTC") {
  const RunResults run = one_drive();
  const auto result = made(run, Format::kml);
  const Folder folder;
  require_well_formed(folder, "a.kml", result.text);
  static const std::regex coord("<gx:coord>(\\S+) (\\S+) (\\S+)</gx:coord>"), when("<when>([^<]+)</when>");
  const auto coords = all_matches(result.text, coord), times = all_matches(result.text, when);
  REQUIRE(coords.size() == 50);
  REQUIRE(times.size() == 50);
  for (std::size_t i = 0; i < 50; ++i) {
    CHECK(std::abs(std::stod(coords[i][1]) - value(run, 1, i) / degree) <= 0.51e-9);
    CHECK(std::abs(std::stod(coords[i][2]) - value(run, 0, i) / degree) <= 0.51e-9);
  }
  CHECK(times[0][1] == first_time);
  CHECK(times[1][1] == "2025-08-24T00:01:22.200Z");
  CHECK(contains(result.text, "a &lt;drive&gt; &amp; &quot;more&quot;"));
  CHECK(contains(result.text, "clampToGround"));
  REQUIRE(result.notes.size() == 1);
  CHECK(contains(result.notes[0], "the file has no heights: kml needs heights above sea level"));
  CHECK(result.time->from == "/sources/gnss/week of the run's config");
  const auto high = made(run, Format::kml, [](Request& request) { request.geoid_separation = 22.5; });
  CHECK(contains(high.text, "<altitudeMode>absolute</altitudeMode>"));
  CHECK(all_matches(high.text, coord)[0][3] == "37.500");  // 60 - 22.5
  CHECK(high.notes.empty());
}

TEST_CASE("KML by colour: every record in a stretch, stretches join, darker where sigma is smaller") {
  const RunResults run = one_drive();
  const auto result = made(run, Format::kml, [](Request& request) { request.is_coloured = true; });
  const Folder folder;
  require_well_formed(folder, "c.kml", result.text);
  static const std::regex style("<styleUrl>#s([0-9])</styleUrl>"), when("<when>([^<]+)</when>");
  const auto styles = all_matches(result.text, style);
  REQUIRE(styles.size() == 5);  // sigma only grows
  for (std::size_t i = 0; i < 5; ++i) CHECK(styles[i][1] == std::to_string(i));
  CHECK(all_matches(result.text, when).size() == 50 + 4);
}

TEST_CASE("without a time base KML and GPX have no times and say so, pos and nmea are refused") {
  const RunResults run = run_of({drive("ins", 5, 0.2)}, R"({"sources": {}})");
  for (const Format format : {Format::kml, Format::gpx}) {
    const auto result = made(run, format);
    CHECK_FALSE(contains(result.text, "<when>"));
    CHECK_FALSE(contains(result.text, "<time>"));
    CHECK(contains(result.notes.at(0), "the file has no times: the run does not give the origin of its time"));
  }
  const Folder folder;
  require_well_formed(folder, "l.kml", made(run, Format::kml).text);
  for (const Format format : {Format::pos, Format::nmea}) CHECK(contains(refusal(run, format), "--week N"));
  CHECK(contains(refusal(run, Format::csv, [](Request& request) { request.columns = {"utc"}; }), "--week N"));
}

TEST_CASE("GPX is well-formed, with times of UTC and heights above the sea where the geoid is given") {
  const RunResults run = one_drive();
  const auto plain = made(run, Format::gpx);
  CHECK_FALSE(contains(plain.text, "<ele>"));
  const auto result = made(run, Format::gpx, [](Request& request) { request.geoid_separation = 22.5; });
  const Folder folder;
  require_well_formed(folder, "a.gpx", result.text);
  static const std::regex point(
      "<trkpt lat=\"([^\"]+)\" "
      "lon=\"([^\"]+)\"><ele>([^<]+)</ele><time>([^<]+)</time><geoidheight>22.500</geoidheight>");
  const auto points = all_matches(result.text, point);
  REQUIRE(points.size() == 50);
  for (std::size_t i = 0; i < 50; ++i) {
    CHECK(std::abs(std::stod(points[i][1]) - value(run, 0, i) / degree) <= 0.51e-9);
    CHECK(std::abs(std::stod(points[i][2]) - value(run, 1, i) / degree) <= 0.51e-9);
    CHECK(std::abs(std::stod(points[i][3]) - (value(run, 2, i) - 22.5)) <= 0.51e-3);
  }
  CHECK(points[0][4] == first_time);
}

TEST_CASE("time: GPS and UTC are 18 s apart, leap seconds may be given, and contradictions are refused") {
  const RunResults run = run_of({drive("ins", 2, 0.2)}, R"({"sources": {}})");
  const auto first = [&](const std::function<void(Request&)>& change) {
    static const std::regex time("<time>([^<]+)</time>");
    return all_matches(made(run, Format::gpx, change).text, time).at(0)[1].str();
  };
  CHECK(first([](Request& r) { r.time.week = 2381; }) == first_time);
  CHECK(first([](Request& r) { r.time = {2381, "", 0}; }) == "2025-08-24T00:01:40.000Z");
  CHECK(first([](Request& r) { r.time.epoch = "2026-01-02T03:04:05Z"; }) == "2026-01-02T03:05:45.000Z");
  CHECK(contains(refusal(run, Format::gpx, [](Request& r) { r.time = {2381, "2026-01-02", {}}; }), "give one of them"));
  CHECK(contains(refusal(run, Format::gpx, [](Request& r) { r.time.epoch = "yesterday"; }), "not an instant of UTC"));
  CHECK(contains(refusal(run, Format::gpx, [](Request& r) { r.time.leap_seconds = 18; }), "--week selects it"));
  const char* const twice =
      R"({"sources": {"a": {"type": "ublox", "week": 2381}, "b": {"type": "nmea", "epoch": "2025-08-24"}}})";
  CHECK(contains(refusal(run_of({drive("ins", 2, 0.2)}, twice), Format::gpx), "gives two different origins of time"));
  const char* const same =
      R"({"sources": {"a": {"type": "x", "week": 2381}, "b": {"type": "y", "epoch": "2025-08-23T23:59:42Z"}}})";
  CHECK(refusal(run_of({drive("ins", 2, 0.2)}, same), Format::gpx).empty());
}

TEST_CASE("pos is read by our own rtklib_pos as it was: position, velocity up, sigma, time") {
  const RunResults run = one_drive();
  const auto result = made(run, Format::pos);
  const Folder folder;
  const Recorded<rtklib::PosSource> back({{"path", folder.write("a.pos", result.text)}, {"week", 2381}});
  CHECK(back.reports.empty());
  const auto samples = back.of("");
  REQUIRE(samples.size() == 50);
  for (std::size_t i = 0; i < 50; ++i) {
    const Sample& s = samples[i];
    INFO(i);
    CHECK(s.t == static_cast<Time>(std::llround(run.filters[0].t[i] * 1e9)));
    CHECK(std::abs(s["lat"] - value(run, 0, i)) <= 0.51e-9 * degree);
    CHECK(std::abs(s["lon"] - value(run, 1, i)) <= 0.51e-9 * degree);
    CHECK(std::abs(s["height"] - value(run, 2, i)) <= 0.51e-4);
    CHECK(std::abs(s["vn"] - value(run, 3, i)) <= 0.51e-5);
    CHECK(std::abs(s["ve"] - value(run, 4, i)) <= 0.51e-5);
    CHECK(std::abs(s["vd"] - value(run, 5, i)) <= 0.51e-5);
    const auto& sigma = run.filters[0].estimates;
    // A radian of latitude at 33.9 deg south is 6 355 km of the meridian, one of longitude 5 305 km (to 0.1 %).
    CHECK(std::abs(s["position_sd_n"] / (sigma[0].sigma[i] * 6355.2e3) - 1) < 1e-3);
    CHECK(std::abs(s["position_sd_e"] / (sigma[1].sigma[i] * 5299.6e3) - 1) < 1e-3);
    CHECK(std::abs(s["position_sd_d"] - sigma[2].sigma[i]) <= 0.51e-4);
    CHECK(std::abs(s["velocity_sd_d"] - sigma[5].sigma[i]) <= 0.51e-5);
  }
}

TEST_CASE("an ECEF state is a pos of x, y, z, and is refused a colour") {
  FilterResults filter;
  filter.name = "gnss";
  filter.t = {0, 1};
  const double xyz[] = {-4646050.1, 2553206.3, -3534394.7};
  const char* names[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i)
    filter.estimates.push_back({"position", names[i], "m", "", false, {xyz[i], xyz[i] + 1}, {2, 3}, "position.ecef"});
  const RunResults run = run_of({filter}, of_week);
  const Folder folder;
  const auto text = made(run, Format::pos).text;
  const Recorded<rtklib::PosSource> back({{"path", folder.write("a.pos", text)}, {"week", 2381}});
  CHECK(back.reports.empty());
  REQUIRE(back.samples.size() == 2);
  const auto kml = made(run, Format::kml).text;
  static const std::regex coord("<gx:coord>(\\S+) (\\S+) (\\S+)</gx:coord>");
  const auto coords = all_matches(kml, coord);
  REQUIRE(coords.size() == 2);
  CHECK(std::abs(std::stod(coords[0][1]) - back.samples[0]["lon"] / degree) < 2e-9);
  CHECK(std::abs(std::stod(coords[0][2]) - back.samples[0]["lat"] / degree) < 2e-9);
  CHECK(contains(refusal(run, Format::kml, [](Request& r) { r.is_coloured = true; }), "none is horizontal"));
}

TEST_CASE("pos is read by RTKLIB: pos2kml makes the same track of it") {
  if (!has("pos2kml")) return skip("no pos2kml (Debian package rtklib)");
  const RunResults run = one_drive();
  const Folder folder;
  const std::string file = folder.write("a.pos", made(run, Format::pos).text);
  REQUIRE(std::system(("pos2kml '" + file + "' > /dev/null 2>&1").c_str()) == 0);
  const std::string kml = bytes_of(folder.file("a.kml"));
  static const std::regex line("<LineString>[^]*?<coordinates>([^<]+)</coordinates>");
  std::smatch found;
  REQUIRE(std::regex_search(kml, found, line));
  std::istringstream numbers(std::regex_replace(found[1].str(), std::regex(","), " "));
  std::size_t n = 0;
  for (double lon = 0, lat = 0, height = 0; numbers >> lon >> lat >> height; ++n) {
    REQUIRE(n < 50);
    CHECK(std::abs(lon - value(run, 1, n) / degree) < 2e-9);
    CHECK(std::abs(lat - value(run, 0, n) / degree) < 2e-9);
  }
  CHECK(n == 50);
}

TEST_CASE("nmea is read by gpsd: positions, times, speed and course") {
  if (!has("gpsdecode")) return skip("no gpsdecode (Debian package gpsd-clients)");
  const RunResults run = one_drive();
  const Folder folder;
  const std::string file =
      folder.write("a.nmea", made(run, Format::nmea, [](Request& r) { r.geoid_separation = 22.5; }).text);
  const std::string out = folder.file("a.json");
  REQUIRE(std::system(("gpsdecode -j < '" + file + "' > '" + out + "' 2> /dev/null").c_str()) == 0);
  std::map<std::string, json> reports;
  std::ifstream lines(out);
  for (std::string line; std::getline(lines, line);) {
    const json report = json::parse(line);
    if (report.at("class") == "TPV" && report.contains("time") && report.contains("lat"))
      reports[report["time"]] = report;
  }
  // gpsd reports nothing of the first epoch: it waits for one more to know where epochs end.
  REQUIRE(reports.size() >= 49);
  std::size_t i = 50 - reports.size();
  for (const auto& [time, report] : reports) {
    INFO(time << " " << report);
    char expected[40];
    std::snprintf(expected, sizeof expected, "2025-08-24T00:01:%06.3fZ", 22 + 0.2 * static_cast<double>(i));
    CHECK(time == expected);
    const double vn = value(run, 3, i), ve = value(run, 4, i);
    CHECK(std::abs(report.at("lat").get<double>() - value(run, 0, i) / degree) < 2e-9);
    CHECK(std::abs(report.at("lon").get<double>() - value(run, 1, i) / degree) < 2e-9);
    CHECK(std::abs(report.at("altMSL").get<double>() - (value(run, 2, i) - 22.5)) < 1e-3);
    CHECK(std::abs(report.at("track").get<double>() - std::atan2(ve, vn) / degree) < 1e-3);
    CHECK(std::abs(report.at("speed").get<double>() - std::hypot(vn, ve)) < 2e-3);
    ++i;
  }
  CHECK(contains(bytes_of(file), "$GPHDT,051.566,T*"));  // 0.9 rad
}

TEST_CASE("csv: columns by name and block, degrees, sigma, a wrong name lists what there is") {
  const RunResults run = one_drive();
  const auto all = made(run, Format::csv);
  CHECK(all.text.starts_with("t[s],position.lat[deg],position.lon[deg],position.height[m],velocity.vn[m/s],"));
  CHECK_FALSE(contains(all.text, "sigma"));
  const auto some = made(run, Format::csv, [](Request& r) {
    r.columns = {"velocity", "utc", "position.lat.sigma"};
    r.every = 10;
  });
  std::istringstream lines(some.text);
  std::string head, first;
  std::getline(lines, head);
  std::getline(lines, first);
  CHECK(head == "t[s],utc,velocity.vn[m/s],velocity.ve[m/s],velocity.vd[m/s],position.lat.sigma[deg]");
  CHECK(first.starts_with("100,2025-08-24T00:01:22.000000Z,12,15,-0.5,"));
  CHECK(std::abs(std::stod(first.substr(first.rfind(',') + 1)) * degree - 1e-7) < 1e-20);
  CHECK(some.records == 5);
  CHECK(some.of == 50);
  const std::string wrong = refusal(run, Format::csv, [](Request& r) { r.columns = {"velocity.ne"}; });
  CHECK(contains(wrong, "there is no column 'velocity.ne'; did you mean 'velocity.ve'?"));
}

TEST_CASE("csv --local: north, east, down as GeographicLib has them, about an origin that is said") {
  const RunResults run = one_drive();
  const auto rows = [](const std::string& text) {
    std::vector<std::array<double, 3>> list;
    std::istringstream lines(text);
    std::string line;
    for (std::getline(lines, line); std::getline(lines, line);) {
      std::array<double, 3> row{};
      double t = 0;
      REQUIRE(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &t, &row[0], &row[1], &row[2]) == 4);
      list.push_back(row);
    }
    return list;
  };
  const auto check = [&](const convert::Result& result, double lat, double lon, double height) {
    const GeographicLib::LocalCartesian oracle(lat, lon, height);
    const auto list = rows(result.text);
    REQUIRE(list.size() == 50);
    for (std::size_t i = 0; i < 50; ++i) {
      double east = 0, north = 0, up = 0;
      oracle.Forward(value(run, 0, i) / degree, value(run, 1, i) / degree, value(run, 2, i), east, north, up);
      CHECK(std::abs(list[i][0] - north) < 1e-6);
      CHECK(std::abs(list[i][1] - east) < 1e-6);
      CHECK(std::abs(list[i][2] + up) < 1e-6);
    }
  };
  const auto local = [](Request& r) {
    r.is_local = true;
    r.columns = {"position"};
  };
  const auto first = made(run, Format::csv, local);
  CHECK(first.text.starts_with("t[s],position.north[m],position.east[m],position.down[m]\n"));
  CHECK(first.origin->from == "the first record");
  check(first, lat0 / degree, lon0 / degree, height0);
  RunResults with_origin = run;
  with_origin.config["origin"] = {{"lat", "-33.8 deg"}, {"lon", "151.1 deg"}, {"height", 100}};
  const auto configured = made(with_origin, Format::csv, local);
  CHECK(configured.origin->from == "/origin of the run's config");
  check(configured, -33.8, 151.1, 100);
  with_origin.config["origin"]["lat"] = "10 m";
  CHECK(contains(refusal(with_origin, Format::csv, local), "/origin/lat of the run's config is not a quantity in rad"));
}

TEST_CASE("a state north and east in metres needs an origin, and is where that puts it") {
  FilterResults filter;
  filter.name = "cart";
  filter.t = {0, 1};
  filter.estimates = {{"place", "north", "m", "", false, {0, 100}, {1, 1}, "vector:2:m"},
                      {"place", "east", "m", "", false, {0, -50}, {1, 1}, "vector:2:m"}};
  const RunResults run = run_of({filter}, of_week);
  CHECK(contains(refusal(run, Format::gpx), "--origin LAT,LON,HEIGHT"));
  const auto text = made(run, Format::gpx, [](Request& r) {
                      r.origin = convert::Place{lat0, lon0, height0, "--origin"};
                    }).text;
  static const std::regex point("<trkpt lat=\"([^\"]+)\" lon=\"([^\"]+)\">");
  const auto points = all_matches(text, point);
  double lat = 0, lon = 0, height = 0;
  GeographicLib::LocalCartesian(lat0 / degree, lon0 / degree, height0).Reverse(-50, 100, 0, lat, lon, height);
  REQUIRE(points.size() == 2);
  CHECK(std::abs(std::stod(points[1][1]) - lat) < 1e-9);
  CHECK(std::abs(std::stod(points[1][2]) - lon) < 1e-9);
}

TEST_CASE("positions that are not finite are left out and counted, none at all is no file") {
  RunResults run = one_drive();
  for (std::size_t i : {0u, 7u, 49u}) run.filters[0].estimates[1].values[i] = std::nan("");
  const auto result = made(run, Format::gpx);
  CHECK(result.records == 47);
  CHECK(result.left_out == 3);
  CHECK(contains(result.notes[0], "3 records are left out: the position is not finite"));
  CHECK_FALSE(contains(result.text, "nan"));
  for (auto& each : run.filters[0].estimates[0].values) each = std::nan("");
  CHECK(contains(refusal(run, Format::gpx), "has no position that is finite"));
}

TEST_CASE("what cannot be had is refused by name") {
  const RunResults two = run_of({drive("ins", 5, 1), drive("gnss", 5, 1)}, of_week);
  CHECK(contains(refusal(two, Format::kml), "--filter chooses one of them: 'ins', 'gnss'"));
  CHECK(contains(refusal(two, Format::kml, [](Request& r) { r.filter = "inz"; }),
                 "no filter 'inz'; it has 'ins', 'gnss'"));
  CHECK(refusal(two, Format::kml, [](Request& r) { r.filter = "gnss"; }).empty());
  CHECK(contains(refusal(two, Format::gpx, [](Request& r) { r.filter = "ins", r.is_local = true; }),
                 "--local is of --to csv"));
  CHECK(contains(refusal(two, Format::gpx, [](Request& r) { r.filter = "ins", r.is_coloured = true; }),
                 "--colour is of"));
  RunResults bias = one_drive();
  bias.filters[0].estimates.erase(bias.filters[0].estimates.begin(), bias.filters[0].estimates.begin() + 3);
  CHECK(contains(refusal(bias, Format::kml), "estimates no position: none of its blocks ('velocity', 'attitude')"));
  RunResults idle = one_drive();
  idle.filters[0].t.clear();
  CHECK(contains(refusal(idle, Format::kml), "has no estimates"));
}

}  // namespace formats_test
