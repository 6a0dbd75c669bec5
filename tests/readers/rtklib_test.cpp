// SPDX-License-Identifier: Apache-2.0
// Source rtklib_pos: every form of time and coordinates gives the same samples; covariances with their signs; damage.
#include "rtklib/pos_source.hpp"

#include <cstdlib>
#include <numbers>

#include "binnacle/geodesy.hpp"
#include "catch.hpp"
#include "reading.hpp"
#include "recorded_data.hpp"

namespace rtklib_test {

using namespace binnacle;
using namespace binnacle::test;
using namespace binnacle::rtklib;
using nlohmann::json;
using Pos = Recorded<PosSource>;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr std::int64_t week = 2381;
// 2025-08-28 is a Thursday.
constexpr Time start = (4 * 86400 + 17 * 3600 + 30 * 60 + 40) * nanoseconds_per_second;
const Vector3d lla(40.0966916 * degree, -105.1471665 * degree, 1601.435);
const Vector3d v_n(1.5, -0.25, 0.75);

/// North, east, down.
Matrix3d covariance(double scale) {
  Matrix3d P;
  P << 4, 1.5, -0.5, 1.5, 9, 0.25, -0.5, 0.25, 16;
  return P * (scale * scale);
}

std::string text(const char* format, auto... values) {
  char line[512];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

/// 11 22 33 12 23 31 as RTKLIB prints them.
std::string deviations(const Matrix3d& P) {
  const auto root = [](double c) { return c < 0 ? -std::sqrt(-c) : std::sqrt(c); };
  return text(" %.9f %.9f %.9f %.9f %.9f %.9f", root(P(0, 0)), root(P(1, 1)), root(P(2, 2)), root(P(0, 1)),
              root(P(1, 2)), root(P(2, 0)));
}

std::string vector(const Vector3d& v) { return text(" %.9f %.9f %.9f", v[0], v[1], v[2]); }

/// From north, east, down to the axes of a form.
Matrix3d axes(char form) {
  if (form == 'x') return geodesy::C_en(lla[0], lla[1]);
  Matrix3d C = Matrix3d::Zero();
  C(0, form == 'b' ? 1 : 0) = C(1, form == 'b' ? 0 : 1) = 1;
  C(2, 2) = -1;
  return C;
}

std::string dms(double angle) {
  const double degrees = std::abs(angle) / degree, minutes = (degrees - std::floor(degrees)) * 60;
  return text(" %s%d %02d %.10f", angle < 0 ? "-" : "", static_cast<int>(degrees), static_cast<int>(minutes),
              (minutes - std::floor(minutes)) * 60);
}

const Vector3d base(40.09 * degree, -105.15 * degree, 1590);

std::string position(char form) {
  if (form == 'd') return text(" %.12f %.12f %.6f", lla[0] / degree, lla[1] / degree, lla[2]);
  if (form == 's') return dms(lla[0]) + dms(lla[1]) + text(" %.6f", lla[2]);
  const Vector3d r = geodesy::ecef_from_lla(lla);
  if (form == 'x') return vector(r);
  const Vector3d ned = geodesy::C_en(base[0], base[1]).transpose() * (r - geodesy::ecef_from_lla(base));
  return vector({ned[1], ned[0], -ned[2]});
}

std::string columns(char form) {
  switch (form) {
    case 'd':
      return "latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio "
             "vn(m/s) ve(m/s) vu(m/s) sdvn sdve sdvu sdvne sdveu sdvun";
    case 's':
      return "latitude(d'\") longitude(d'\") height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio "
             "vn(m/s) ve(m/s) vu(m/s) sdvn sdve sdvu sdvne sdveu sdvun";
    case 'x':
      return "x-ecef(m) y-ecef(m) z-ecef(m) Q ns sdx(m) sdy(m) sdz(m) sdxy(m) sdyz(m) sdzx(m) age(s) ratio vx(m/s) "
             "vy(m/s) vz(m/s) sdvx sdvy sdvz sdvxy sdvyz sdvzx";
    default:
      return "e-baseline(m) n-baseline(m) u-baseline(m) Q ns sde(m) sdn(m) sdu(m) sden(m) sdnu(m) sdue(m) age(s) ratio "
             "ve(m/s) vn(m/s) vu(m/s) sdve sdvn sdvu sdven sdvnu sdvue";
  }
}

std::string time_label(int system, bool is_week, double more) {
  const double shift = system == 0 ? 0 : system == 1 ? -18 : -18 + 9 * 3600;
  const double s = 4 * 86400 + 17 * 3600 + 30 * 60 + 40 + more + shift;
  if (is_week) return text("%d %.4f", static_cast<int>(week), s);
  const double of_day = s - 4 * 86400;
  const bool is_next = of_day >= 86400;  // in Japan it is Friday
  const double d = is_next ? of_day - 86400 : of_day;
  return text("2025/08/%d %02d:%02d:%06.3f", is_next ? 29 : 28, static_cast<int>(d / 3600),
              static_cast<int>(d / 60) % 60, std::fmod(d, 60.0));
}

std::string row(char form, int system, bool is_week, double more = 0) {
  const Matrix3d C = axes(form);
  return time_label(system, is_week, more) + position(form) + " 2 17" +
         deviations(C * covariance(0.01) * C.transpose()) + " 0.80 3.5" + vector(C * v_n) +
         deviations(C * covariance(0.1) * C.transpose()) + "\n";
}

std::string header(char form, int system) {
  return "% program   : RTKLIB ver.2.4.3\n% ref pos   :" +
         (form == 's' ? dms(base[0]) + dms(base[1]) + text(" %.4f", base[2])
                      : text(" %.12f %.12f %.4f", base[0] / degree, base[1] / degree, base[2])) +
         "\n%\n% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,3:sbas,4:dgps,5:single,6:ppp,ns=# of satellites)\n% "
         " " +
         (system == 0   ? "GPST"
          : system == 1 ? "UTC"
                        : "JST") +
         " " + columns(form) + "\n";
}

Pos read(const std::string& content, json parameters = json::object()) {
  const Folder folder;
  parameters["path"] = folder.write("track.pos", content);
  parameters["week"] = week;
  return Pos(parameters);
}

}  // namespace

TEST_CASE("every form of time and coordinates gives the same sample") {
  for (const char form : {'d', 's', 'x', 'b'})
    for (const int system : {0, 1, 2})
      for (const bool is_week : {false, true}) {
        INFO(form << " " << system << " " << is_week);
        const Pos r = read(header(form, system) + row(form, system, is_week) + row(form, system, is_week, 0.25));
        CHECK(r.reports.empty());
        REQUIRE(r.samples.size() == 2);
        const Sample& s = r.samples[0];
        CHECK(s.t == start);
        CHECK(r.samples[1].t == start + 250'000'000);
        CHECK(std::abs(s["lat"] - lla[0]) * 6.4e6 < 1e-6);
        CHECK(std::abs(s["lon"] - lla[1]) * 6.4e6 < 1e-6);
        CHECK(std::abs(s["height"] - lla[2]) < 1e-5);
        CHECK(std::abs(s["vn"] - 1.5) < 1e-8);
        CHECK(std::abs(s["ve"] + 0.25) < 1e-8);
        CHECK(std::abs(s["vd"] - 0.75) < 1e-8);
        CHECK(std::abs(s["position_sd_n"] - 0.02) < 1e-8);
        CHECK(std::abs(s["position_sd_e"] - 0.03) < 1e-8);
        CHECK(std::abs(s["velocity_sd_d"] - 0.4) < 1e-8);
        CHECK(s["quality"] == 2);
        CHECK(s["satellites"] == 17);
        CHECK(s["age"] == 0.8);
        CHECK(s["ratio"] == 3.5);
        const Eigen::Map<const Eigen::Matrix<double, 6, 6>> P(s.covariance.data());
        CHECK((P.topLeftCorner<3, 3>() - covariance(0.01)).norm() < 1e-9);
        CHECK((P.bottomRightCorner<3, 3>() - covariance(0.1)).norm() < 1e-8);
        if (form != 'b') continue;
        CHECK(std::abs(s["relative_n"] - (geodesy::C_en(base[0], base[1]).transpose() *
                                          (geodesy::ecef_from_lla(lla) - geodesy::ecef_from_lla(base)))[0]) < 1e-6);
      }
}

TEST_CASE("files without a header, other separators, a baseline without its station") {
  const json stated{{"coordinates", "degrees"}, {"time_system", "utc"}, {"velocity", true}};
  CHECK(read(row('d', 1, false), stated).samples.at(0).t == start);
  std::string with_commas = row('d', 1, false);
  for (char& c : with_commas)
    if (c == ' ') c = ',';
  with_commas[10] = ' ';
  CHECK(read(with_commas, stated).samples.size() == 1);
  CHECK_THROWS_AS(read(row('d', 0, false)), ComponentError);
  CHECK_THROWS_AS(read("$GPGGA,1\n"), ComponentError);
  CHECK_THROWS_AS(read(row('d', 0, false), {{"coordinates", "degrees"}}), ComponentError);
  std::string without = header('b', 0);
  without.replace(without.find("ref pos"), 7, "no  pos");
  const Pos r = read(without + row('b', 0, false));
  CHECK(r.samples.at(0).fields.count("lat") == 0);
  CHECK(r.samples.at(0).fields.count("relative_n") == 1);
  const Pos stated_base =
      read(without + row('b', 0, false), {{"reference", {{"lat", base[0]}, {"lon", base[1]}, {"height", base[2]}}}});
  CHECK(std::abs(stated_base.samples.at(0)["lat"] - lla[0]) * 6.4e6 < 1e-6);
}

TEST_CASE("heights above the sea, another datum") {
  std::string geodetic = header('d', 0);
  geodetic.replace(geodetic.find("ellipsoidal"), 11, "geodetic");
  const Pos r = read(geodetic + row('d', 0, false));
  CHECK(std::isnan(r.samples.at(0)["height"]));
  CHECK(r.has_reported("B064"));
  CHECK(std::abs(read(geodetic + row('d', 0, false), {{"geoid_separation", -17.5}}).samples.at(0)["height"] -
                 1583.935) < 1e-6);
  CHECK(read(geodetic + row('d', 0, false), {{"geoid_separation", -17.5}}).reports.empty());
  // Heights above the ellipsoid have nothing to add it to.
  const Pos unused = read(header('d', 0) + row('d', 0, false), {{"geoid_separation", -17.5}});
  CHECK(unused.samples.at(0)["height"] == read(header('d', 0) + row('d', 0, false)).samples.at(0)["height"]);
  CHECK(unused.has_reported("B032 "));
  CHECK(unused.has_reported("'geoid_separation' has no effect"));
  std::string tokyo = header('d', 0);
  tokyo.replace(tokyo.find("WGS84"), 5, "Tokyo");
  CHECK_THROWS_AS(read(tokyo + row('d', 0, false)), ComponentError);
}

TEST_CASE("lines that are damaged are left out, counted, and named by line") {
  const std::string good = row('d', 0, false), later = row('d', 0, false, 1), last = row('d', 0, false, 2);
  std::string letter = later;
  letter.replace(letter.find("-105"), 4, "-1o5");
  const Pos r = read(header('d', 0) + good + letter + later.substr(0, 60) + "\n" + later + good + last);
  CHECK(r.samples.size() == 3);
  CHECK(r.has_reported("B062 track.pos:7 2 lines skipped, the first: '-1o5"));
  CHECK(r.has_reported("B063 track.pos:10 1 solution skipped: out of order"));
  CHECK_THROWS_AS(read(header('d', 0) + good + letter, {{"on_error", "stop"}}), ComponentError);
  CHECK_THROWS_AS(read(header('d', 0)), ComponentError);
  std::string none = later;
  none.replace(none.find(" 2 17 "), 6, " 0 17 ");
  CHECK(read(header('d', 0) + good + none).has_reported("B065 track.pos:0 1 lines with Q = 0"));
}

TEST_CASE("live: lines as they come") {
  const Folder folder;
  const std::string file =
      folder.write("track.pos", header('x', 0) + row('x', 0, false) + "spoilt\n" + row('x', 0, false, 1));
  const Pos r({{"from", "file:" + file}, {"week", week}, {"velocity", true}});
  REQUIRE(r.samples.size() == 2);
  CHECK(std::abs(r.samples[1]["lat"] - lla[0]) * 6.4e6 < 1e-6);
  CHECK(std::abs(r.samples[1]["vd"] - 0.75) < 1e-8);
  CHECK(r.has_reported("a line is invalid: it has 1 words instead of 24"));
}

TEST_CASE("live: a line an hour ahead does not refuse those after it") {
  const Folder folder;
  const std::string file = folder.write("track.pos", header('x', 0) + row('x', 0, false) + row('x', 0, false, 3600) +
                                                         row('x', 0, false, 1) + row('x', 0, false, 2));
  const Pos r({{"from", "file:" + file}, {"week", week}, {"velocity", true}});
  REQUIRE(r.samples.size() == 3);
  CHECK(r.samples[2].t - r.samples[0].t == 2 * nanoseconds_per_second);
  CHECK(r.has_reported("a line is invalid: its time is far ahead of those before"));
}

TEST_CASE("the recorded .pos is read as it is") {
  const auto folder = recorded_data("receivers");
  if (!folder) return;
  const Pos r({{"path", (*folder / "walk.pos.gz").string()}, {"week", week}});
  CHECK(r.reports.empty());
  REQUIRE(r.samples.size() == 536);
  const Sample& s = r.samples[2];  // 2025/08/28 17:30:40.249 40.0966916 -105.1471665 1601.431 1 25 …
  CHECK(s.t == start + 249'000'000);
  CHECK(std::abs(s["lat"] / degree - 40.0966916) < 1e-12);
  CHECK(std::abs(s["lon"] / degree + 105.1471665) < 1e-12);
  CHECK(s["height"] == 1601.431);
  CHECK(s["quality"] == 1);
  CHECK(s["satellites"] == 25);
  CHECK(s["position_sd_n"] == std::sqrt(0.0098995 * 0.0098995));
  CHECK(s["vn"] == -0.005);
  CHECK(s["ve"] == 0.001);
  CHECK(s["vd"] == 0.006);
  CHECK(std::abs(s["velocity_sd_d"] - 0.046669) < 1e-15);
  std::map<double, int> qualities;
  for (const Sample& sample : r.samples) ++qualities[sample["quality"]];
  CHECK(qualities[1] == 349);
  CHECK(qualities[2] == 187);
}

TEST_CASE("solutions of rnx2rtkp in all its forms are one track") {
  const auto folder = recorded_data("receivers");
  if (!folder) return;
  if (std::system("command -v rnx2rtkp > /dev/null 2>&1 && command -v convbin > /dev/null 2>&1") != 0)
    return skip("no rnx2rtkp (Debian package rtklib)");
  const Folder made;
  const std::string obs = made.file("walk.obs"), nav = made.file("walk.nav");
  REQUIRE(std::system(("convbin -r ubx -v 3.04 -od -os -o '" + obs + "' -n '" + nav + "' '" +
                       (*folder / "walk.ubx").string() + "' > /dev/null 2>&1")
                          .c_str()) == 0);
  // -g: degrees, minutes and seconds; -e: ECEF; -t: calendar; -u: UTC; -s: separator.
  std::map<std::string, std::vector<Sample>> tracks;
  for (const std::string form : {"", "-g", "-e", "-t", "-t -u", "-u -e", "-s ,"}) {
    const std::string pos = made.file("track.pos");
    REQUIRE(
        std::system(("rnx2rtkp -p 0 -m 5 " + form + " -o '" + pos + "' '" + obs + "' '" + nav + "' > /dev/null 2>&1")
                        .c_str()) == 0);
    tracks[form] = Pos({{"path", pos}, {"week", week}}).samples;
  }
  const auto& first = tracks[""];
  INFO(first.size());
  REQUIRE(first.size() > 50);
  for (const auto& [form, track] : tracks) {
    INFO("form '" << form << "'");
    REQUIRE(track.size() == first.size());
    for (std::size_t i = 0; i < track.size(); ++i) {
      REQUIRE(std::abs(track[i].t - first[i].t) <= 1'100'000);  // three decimals
      REQUIRE(std::abs(track[i]["lat"] - first[i]["lat"]) * 6.4e6 < 2e-3);
      REQUIRE(std::abs(track[i]["lon"] - first[i]["lon"]) * 6.4e6 < 2e-3);
      REQUIRE(std::abs(track[i]["height"] - first[i]["height"]) < 2e-3);
      REQUIRE(std::abs(track[i]["position_sd_d"] - first[i]["position_sd_d"]) < 2e-3);
      REQUIRE(std::abs(track[i].covariance.at(1) - first[i].covariance.at(1)) < 2e-2);
    }
  }
}

}  // namespace rtklib_test
