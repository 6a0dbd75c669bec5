// SPDX-License-Identifier: Apache-2.0
// Source nmea: sentences that RTKLIB and the receiver of the walk wrote, GSA and PASHR, and what is not read.
#include <cstdlib>
#include <numbers>

#include "catch.hpp"
#include "nmea/nmea_source.hpp"
#include "nmea/sentence.hpp"
#include "reading.hpp"
#include "recorded_data.hpp"
#include "rtklib/pos_source.hpp"
#include "ublox/ublox_source.hpp"

namespace nmea_test {

using namespace binnacle;
using namespace binnacle::test;
using nlohmann::json;
using Nmea = Recorded<nmea::NmeaSource>;

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr int week = 2381;

std::string sentence(const std::string& body) {
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", nmea::checksum(body));
  return "$" + body + end;
}

Nmea read(const std::string& content, json parameters = json::object()) {
  const Folder folder;
  parameters["path"] = folder.write("log.nmea", content);
  return Nmea(parameters);
}

const std::string rmc = sentence("GNRMC,120000.00,A,4807.0380,N,01131.0000,E,022.4,084.4,231121,,,A");
const std::string gga = sentence("GNGGA,120000.00,4807.0380,N,01131.0000,E,4,18,0.9,545.4,M,46.9,M,,");

}  // namespace

TEST_CASE("GSA, of which there is one for each constellation") {
  const std::string gps = sentence("GNGSA,A,3,04,05,09,12,,,,,,,,,2.5,1.3,2.1,1"),
                    galileo = sentence("GNGSA,A,3,07,08,,,,,,,,,,,2.5,1.3,2.1,3");
  const Nmea r = read(rmc + gga + gps + galileo);
  CHECK(r.reports.empty());
  const Sample s = r.of("").at(0);
  CHECK(s["dimension"] == 3);
  CHECK(s["pdop"] == 2.5);
  CHECK(s["vdop"] == 2.1);
  CHECK(s["hdop"] == 0.9);  // of GGA
  CHECK(read(rmc + gps).of("").at(0)["hdop"] == 1.3);
}

TEST_CASE("PASHR: attitude with its deviations") {
  const std::string shr = sentence("PASHR,120000.00,123.45,T,-1.50,+2.25,-0.10,0.015,0.025,0.045,2,1");
  const Nmea r = read(rmc + gga + shr, {{"talkers", {"GN"}}});
  CHECK(r.reports.empty());
  REQUIRE(r.of("attitude").size() == 1);
  const Sample s = r.of("attitude")[0];
  CHECK(s.t == r.of("")[0].t);
  CHECK(std::abs(s["yaw"] - 123.45 * degree) < 1e-15);
  CHECK(std::abs(s["roll"] + 1.5 * degree) < 1e-15);
  CHECK(std::abs(s["pitch"] - 2.25 * degree) < 1e-15);
  CHECK(s["heave"] == -0.1);
  CHECK(std::abs(s["roll_sd"] - 0.015 * degree) < 1e-15);
  CHECK(std::abs(s["pitch_sd"] - 0.025 * degree) < 1e-15);
  CHECK(std::abs(s["yaw_sd"] - 0.045 * degree) < 1e-15);
  CHECK(s["quality"] == 2);
  CHECK(s["inertial"] == 1);
  // Other sentences of that name carry no attitude.
  CHECK(read(rmc + sentence("PASHR,ATT,1,2,3")).of("attitude").empty());
}

TEST_CASE("sentences and lines that are not read are counted by kind") {
  const Nmea r = read(rmc + sentence("GNGLL,4807.0380,N,01131.0000,E,120000.00,A,A") + sentence("GPGSV,1,1,00") +
                      sentence("GPGSV,1,1,00") + "noise\r\n\r\n" + sentence("PUBX,00,1"));
  CHECK(
      r.has_reported("B065 log.nmea:0 not read: GLL (1), GSV (2), lines without a sentence (1), proprietary sentences "
                     "and queries (1)"));
}

TEST_CASE("NMEA that RTKLIB made of the walk is read back to its digits") {
  const auto folder = recorded_data("receivers");
  if (!folder) return;
  if (std::system("command -v rnx2rtkp > /dev/null 2>&1 && command -v convbin > /dev/null 2>&1") != 0)
    return skip("no rnx2rtkp (Debian package rtklib)");
  const Folder made;
  const std::string obs = made.file("walk.obs"), nav = made.file("walk.nav");
  const auto run = [](const std::string& command) {
    REQUIRE(std::system((command + " > /dev/null 2>&1").c_str()) == 0);
  };
  run("convbin -r ubx -v 3.04 -od -os -o '" + obs + "' -n '" + nav + "' '" + (*folder / "walk.ubx").string() + "'");
  run("rnx2rtkp -p 0 -m 5 -n -o '" + made.file("walk.nmea") + "' '" + obs + "' '" + nav + "'");
  run("rnx2rtkp -p 0 -m 5 -o '" + made.file("walk.pos") + "' '" + obs + "' '" + nav + "'");
  const auto positions = Recorded<rtklib::PosSource>({{"path", made.file("walk.pos")}, {"week", week}}).samples;
  const Nmea sentences({{"path", made.file("walk.nmea")}, {"week", week}});
  INFO(sentences.reports);
  const auto fixes = sentences.of("");
  REQUIRE(fixes.size() > 100);
  std::size_t compared = 0;
  for (const Sample& s : fixes) {
    // Two decimals of a second.
    const auto same = std::find_if(positions.begin(), positions.end(),
                                   [&](const Sample& p) { return std::abs(p.t - s.t) <= 6'000'000; });
    if (same == positions.end()) continue;
    REQUIRE(std::abs(s["lat"] - (*same)["lat"]) / degree <= 1e-9 + 0.51e-7 / 60 * 10);
    REQUIRE(std::abs(s["lon"] - (*same)["lon"]) / degree <= 1e-9 + 0.51e-7 / 60 * 10);
    REQUIRE(std::abs(s["height"] - (*same)["height"]) <= 1.1e-3);
    REQUIRE(s["satellites"] == (*same)["satellites"]);
    ++compared;
  }
  CHECK(compared == fixes.size());
}

TEST_CASE("sentences that the receiver of the walk sent beside its binary messages agree with them") {
  const auto folder = recorded_data("receivers");
  if (!folder) return;
  const std::string file = (*folder / "walk.ubx").string();
  const Nmea sentences({{"path", file}, {"week", week}});
  INFO(sentences.reports);
  const auto solutions = Recorded<ublox::UbloxSource>({{"path", file}, {"week", week}}).of("");
  std::size_t compared = 0;
  for (const Sample& s : sentences.of("")) {
    const auto same = std::find_if(solutions.begin(), solutions.end(),
                                   [&](const Sample& p) { return std::abs(p.t - s.t) <= 5'000'000; });
    if (same == solutions.end()) continue;
    REQUIRE(std::abs(s["lat"] - (*same)["lat"]) / degree < 1.5e-7);
    REQUIRE(std::abs(s["lon"] - (*same)["lon"]) / degree < 1.5e-7);
    ++compared;
  }
  CHECK(compared > 100);
}

}  // namespace nmea_test
