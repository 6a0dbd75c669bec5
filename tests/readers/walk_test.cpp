// SPDX-License-Identifier: Apache-2.0
// A recorded walk: ublox against gpsd's and RTKLIB's reading of the same bytes.
#include <cstdlib>
#include <numbers>
#include <optional>

#include "binnacle/geodesy.hpp"
#include "catch.hpp"
#include "gnss/channels.hpp"
#include "gnss/corrections.hpp"
#include "gnss/gps_time.hpp"
#include "reading.hpp"
#include "recorded_data.hpp"
#include "rinex/rinex_source.hpp"
#include "ublox/ublox_source.hpp"

namespace walk_test {

using namespace binnacle;
using namespace binnacle::test;
using nlohmann::json;
using Ubx = Recorded<ublox::UbloxSource>;
using Rinex = Recorded<rinex::RinexSource>;

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr int week = 2381;

bool has_program(const char* name) {
  return std::system(("command -v " + std::string(name) + " > /dev/null 2>&1").c_str()) == 0;
}

std::optional<std::string> walk() {
  const auto folder = recorded_data("receivers");
  if (!folder) return {};
  return (*folder / "walk.ubx").string();
}

/// "2025-08-28T17:30:22.000Z" as GPS time of the week.
Time gps_time_of(const std::string& text) {
  const auto part = [&](std::size_t at, std::size_t count) { return std::stoi(text.substr(at, count)); };
  const Time day = gnss::gps_day(part(0, 4), part(5, 2), part(8, 2)) - 7 * week;
  const Time s = ((day * 24 + part(11, 2)) * 60 + part(14, 2)) * 60 + part(17, 2) + 18;
  return s * nanoseconds_per_second + part(20, 3) * Time{1'000'000};
}

/// convbin's files read by `rinex`.
struct Converted {
  Folder folder;
  std::string obs, nav;
  explicit Converted(const std::string& ubx) : obs(folder.file("walk.obs")), nav(folder.file("walk.nav")) {
    const std::string command =
        "convbin -r ubx -v 3.04 -od -os -o '" + obs + "' -n '" + nav + "' '" + ubx + "' > /dev/null 2>&1";
    REQUIRE(std::system(command.c_str()) == 0);
  }
};

std::map<double, std::map<std::string, double>> by_satellite(const Sample& sample) {
  std::map<double, std::map<std::string, double>> rows;
  for (const auto& row : sample.rows) rows[row.at("satellite")] = row;
  return rows;
}

}  // namespace

namespace {

/// NAV-PVT as ubxtool, gpsd's decoder of UBX, prints it: "velN 1 velE -2 …".
std::vector<std::map<std::string, std::int64_t>> decoded_by_gpsd(const std::string& file) {
  const Folder folder;
  const std::string copy = folder.file("walk.ubx"), out = folder.file("ubxtool.txt");
  std::filesystem::copy_file(file, copy);
  const std::string command = "timeout 120 ubxtool -r -f '" + copy + "' -v 2 -w 2 > '" + out + "' 2>&1 < /dev/null";
  if (std::system(command.c_str()) < 0) return {};
  std::vector<std::map<std::string, std::int64_t>> messages;
  std::ifstream lines(out);
  bool is_pvt = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("UBX-", 0) == 0) {
      is_pvt = line == "UBX-NAV-PVT:";
      if (is_pvt) messages.emplace_back();
      continue;
    }
    std::istringstream words(line);
    for (std::string name, value; is_pvt && words >> name >> value;) try {
        messages.back().emplace(name, std::stoll(value));
      } catch (const std::exception&) {
        break;  // flags in words
      }
  }
  return messages;
}

}  // namespace

TEST_CASE("NAV-PVT of the walk equals gpsd's decoding to its digits") {
  const auto file = walk();
  if (!file) return;
  if (!has_program("ubxtool")) return skip("no ubxtool (Debian package gpsd-clients)");
  const auto theirs = decoded_by_gpsd(*file);
  const Ubx r({{"path", *file}, {"week", week}});
  const auto ours = r.of("");
  REQUIRE(ours.size() == 536);
  REQUIRE(theirs.size() == ours.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    const Sample& s = ours[i];
    const auto is = [&](const char* name, double value, double digit) {
      INFO(i << " " << name << " " << value);
      REQUIRE(theirs[i].at(name) == std::llround(value / digit));
      REQUIRE(std::abs(static_cast<double>(theirs[i].at(name)) * digit - value) < 1e-6 * digit);
    };
    is("iTOW", seconds(s.t), 1e-3);
    is("lat", s["lat"] / degree, 1e-7);
    is("lon", s["lon"] / degree, 1e-7);
    is("height", s["height"], 1e-3);
    is("hMSL", s["height_msl"], 1e-3);
    is("hAcc", s["position_sd_n"], 1e-3);
    is("vAcc", s["position_sd_d"], 1e-3);
    is("velN", s["vn"], 1e-3);
    is("velE", s["ve"], 1e-3);
    is("velD", s["vd"], 1e-3);
    is("gSpeed", s["speed"], 1e-3);
    is("headMot", s["course"] / degree, 1e-5);
    is("sAcc", s["velocity_sd_e"], 1e-3);
    is("headAcc", s["course_sd"] / degree, 1e-5);
    is("pDOP", s["pdop"], 1e-2);
    is("tAcc", s["time_sd"], 1e-9);
    is("numSV", s["satellites"], 1);
    is("fixType", s["fix_type"], 1);
  }
}

TEST_CASE("gpsd's positions and times of the walk are those of NAV-PVT") {
  const auto file = walk();
  if (!file) return;
  if (!has_program("gpsdecode")) return skip("no gpsdecode (Debian package gpsd-clients)");
  const Folder folder;
  const std::string out = folder.file("gpsd.json");
  REQUIRE(std::system(("gpsdecode -j < '" + *file + "' > '" + out + "' 2> /dev/null").c_str()) == 0);
  std::map<Time, json> reports;
  std::ifstream lines(out);
  for (std::string line; std::getline(lines, line);) {
    const json report = json::parse(line);
    if (report.at("class") == "TPV" && report.contains("track") && report.contains("eps"))
      reports.emplace(gps_time_of(report.at("time")), report);
  }
  std::size_t compared = 0;
  const Ubx r({{"path", *file}, {"week", week}});
  for (const Sample& s : r.of("")) {
    const auto found = reports.find(s.t);
    if (found == reports.end()) continue;
    const auto is = [&](const char* name, double value, double half_a_digit) {
      INFO(name << " " << value << " " << found->second);
      REQUIRE(std::abs(found->second.at(name).get<double>() - value) <= half_a_digit);
    };
    is("lat", s["lat"] / degree, 0.51e-9);
    is("lon", s["lon"] / degree, 0.51e-9);
    is("altHAE", s["height"], 0.51e-4);
    is("speed", s["speed"], 0.51e-3);
    ++compared;
  }
  CHECK(compared > 500);
}

TEST_CASE("pseudoranges, range rates and C/N0 of RXM-RAWX equal convbin's RINEX") {
  const auto file = walk();
  if (!file) return;
  if (!has_program("convbin")) return skip("no convbin (Debian package rtklib)");
  const Converted converted(*file);
  const json signals{{"gps", "1C"}, {"galileo", "1C"}};
  const Ubx ours({{"path", *file}, {"week", week}, {"signals", signals}});
  const Rinex theirs({{"observations", converted.obs}, {"week", week}, {"signals", signals}});
  const auto a = ours.of("obs"), b = theirs.of("obs");
  REQUIRE(a.size() == 536);
  REQUIRE(b.size() == a.size());
  std::size_t rows = 0, galileo = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    REQUIRE(std::abs(a[i].t - b[i].t) <= 51);  // seven decimals of a second
    const auto x = by_satellite(a[i]), y = by_satellite(b[i]);
    INFO("epoch " << i << ": " << x.size() << " and " << y.size());
    REQUIRE(x.size() == y.size());
    for (const auto& [satellite, row] : x) {
      INFO(satellite);
      REQUIRE(y.count(satellite) == 1);
      const auto& other = y.at(satellite);
      REQUIRE(std::abs(row.at("pseudorange") - other.at("pseudorange")) <= 0.51e-3);
      REQUIRE(std::abs(row.at("range_rate") - other.at("range_rate")) <= 0.51e-3 * 0.1903);
      REQUIRE(row.at("cn0") == other.at("cn0"));
      ++rows;
      galileo += satellite > 200;
    }
  }
  CHECK(rows > 5000);
  CHECK(galileo > 2000);
}

TEST_CASE("ephemerides equal those of convbin's navigation file") {
  const auto file = walk();
  if (!file) return;
  if (!has_program("convbin")) return skip("no convbin (Debian package rtklib)");
  const Converted converted(*file);
  const json rules{{"choose", "nearest_toe"}, {"max_age", 4 * 3600}, {"week", week}};
  json of_ours = rules, of_theirs = rules;
  of_ours["path"] = *file;
  of_theirs["navigation"] = converted.nav;
  const Ubx ours(of_ours);
  const auto theirs = Rinex(of_theirs).of("ephemeris");
  std::map<double, std::map<std::string, double>> a, b;
  for (const Sample& sample : ours.of("ephemeris")) a.merge(by_satellite(sample));
  for (const Sample& sample : theirs) b.merge(by_satellite(sample));
  CHECK(b.size() == 4);
  REQUIRE(a.size() == b.size());
  for (const auto& [satellite, row] : b) {
    REQUIRE(a.count(satellite) == 1);
    for (const auto& [field, value] : row) {
      INFO(satellite << " " << field);
      const double ours_value = a.at(satellite).at(field);
      REQUIRE(std::abs(ours_value - value) <= 1e-11 * std::abs(value));
    }
  }
}

namespace {

/// Pseudorange less all that is known, of each satellite of a constellation: what is left is the receiver's clock and the
/// ionosphere.
std::vector<double> rests_of(const Ubx& r, double least, double most) {
  std::map<double, gnss::Ephemeris> known;
  const auto fixes = r.of("");
  std::vector<double> rests;
  for (const Sample& sample : r.samples) {
    if (sample.channel == "ephemeris")
      for (const auto& row : sample.rows) {
        std::vector<double> values;
        for (const auto& field : gnss::ephemeris_fields()) values.push_back(row.at(field.name));
        known[row.at("satellite")] = gnss::read_ephemeris(values.data());
      }
    if (sample.channel != "obs") continue;
    const auto fix = std::find_if(fixes.begin(), fixes.end(),
                                  [&](const Sample& f) { return std::abs(f.t - sample.t) < 10'000'000; });
    if (fix == fixes.end()) continue;
    const Eigen::Vector3d lla((*fix)["lat"], (*fix)["lon"], (*fix)["height"]);
    const Eigen::Vector3d antenna = geodesy::ecef_from_lla(lla);
    rests.clear();
    for (const auto& row : sample.rows) {
      const double satellite = row.at("satellite");
      if (satellite < least || satellite > most || known.count(satellite) == 0) continue;
      const gnss::Ephemeris& e = known.at(satellite);
      const double range = row.at("pseudorange");
      const double back = range / gnss::speed_of_light;
      const auto state = gnss::satellite_state(e, sample.t, back);
      const auto path = gnss::signal_path(state.position, antenna, true);
      const auto direction = gnss::direction_in(geodesy::C_en(lla[0], lla[1]), path.direction);
      if (direction.elevation < 15 * degree) continue;
      const double troposphere =
          gnss::troposphere_delay(gnss::Mapping::niell, lla[0], lla[2], direction.elevation, gnss::season_of(240))
              .delay;
      rests.push_back(range - path.range + gnss::speed_of_light * (state.clock - e.group_delay) - troposphere);
    }
  }
  return rests;
}

double spread_of(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end()) - *std::min_element(values.begin(), values.end());
}

}  // namespace

TEST_CASE("ephemerides of the walk put the satellites where its pseudoranges come from") {
  const auto file = walk();
  if (!file) return;
  const Ubx r({{"path", *file},
               {"week", week},
               {"signals", {{"gps", "1C"}, {"galileo", "1C"}}},
               {"choose", "nearest_toe"},
               {"max_age", 4 * 3600}});
  INFO(r.reports);
  const auto gps = rests_of(r, 100, 200), galileo = rests_of(r, 200, 300);
  REQUIRE(gps.size() >= 3);
  REQUIRE(galileo.size() >= 3);
  // What is left differs by ionosphere and multipath; a wrong sign or scale of any term is hundreds of metres.
  CHECK(spread_of(gps) < 25);
  CHECK(spread_of(galileo) < 25);
}

}  // namespace walk_test
