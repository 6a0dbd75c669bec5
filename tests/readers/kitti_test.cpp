// SPDX-License-Identifier: Apache-2.0
// Source oxts: a folder written by the documented form; axes, signs, stamps, what is missing.
#include "kitti/oxts_source.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "catch.hpp"
#include "reading.hpp"

namespace kitti_test {

using namespace binnacle;
using namespace binnacle::test;
using namespace binnacle::kitti;
using nlohmann::json;
using Oxts = Recorded<OxtsSource>;

namespace {

constexpr double degree = std::numbers::pi / 180;

struct State {
  double lat = 49.015, lon = 8.434, alt = 115.25, roll = 0.01, pitch = -0.02, yaw = 2.5;
};

std::string row(const State& s) {
  char text[600];
  std::snprintf(
      text, sizeof text,
      "%.12f %.12f %.6f %.9f %.9f %.9f 8.5 -0.5 8.4 0.1 0.25 0.5 0.75 9.75 0.4 0.7 9.8 0.001 0.002 0.003 0.0011 "
      "0.0021 0.0031 0.125 0.0625 4 9 5 6 7\n",
      s.lat, s.lon, s.alt, s.roll, s.pitch, s.yaw);
  return text;
}

/// A folder of as many rows as there are stamps.
struct Drive {
  Folder folder;
  explicit Drive(const std::string& stamps, int rows, const std::string& oxts = "oxts/") {
    folder.write(oxts + "timestamps.txt", stamps);
    for (int i = 0; i < rows; ++i) write(i, row({}), oxts);
  }
  void write(int index, const std::string& content, const std::string& oxts = "oxts/") const {
    char name[64];
    std::snprintf(name, sizeof name, "data/%010d.txt", index);
    folder.write(oxts + name, content);
  }
  Oxts read(json parameters = json::object()) const {
    parameters["path"] = folder.file("");
    if (!parameters.contains("week")) parameters["epoch"] = "2011-09-30T12:40:00Z";
    return Oxts(parameters);
  }
};

const std::string three =
    "2011-09-30 12:40:59.000000001\n2011-09-30 12:40:59.010000000\n2011-09-30 12:41:00.500000000\n";

}  // namespace

TEST_CASE("a folder of OXTS data: units, axes and signs") {
  const Oxts r = Drive(three, 3).read();
  CHECK(r.reports.empty());
  REQUIRE(r.samples.size() == 6);
  CHECK(r.samples[0].channel == "imu");
  CHECK(r.samples[0].t == 59 * nanoseconds_per_second + 1);
  CHECK(r.samples[0].t0 == no_time);
  CHECK(r.samples[2].t0 == r.samples[0].t);
  CHECK(r.samples[4].t0 == no_time);  // a hole
  const Sample &imu = r.samples[0], &s = r.samples[1];
  CHECK(imu["wx"] == 0.001);
  CHECK(imu["wy"] == -0.002);
  CHECK(imu["wz"] == -0.003);
  CHECK(imu["fx"] == 0.5);
  CHECK(imu["fy"] == -0.75);
  CHECK(imu["fz"] == -9.75);  // at rest a sensor is pushed up
  CHECK(std::abs(s["lat"] - 49.015 * degree) < 1e-14);
  CHECK(std::abs(s["lon"] - 8.434 * degree) < 1e-14);
  CHECK(s["height"] == 115.25);
  CHECK(s["vn"] == 8.5);
  CHECK(s["ve"] == -0.5);
  CHECK(s["vd"] == -0.25);
  CHECK(s["position_sd_e"] == 0.125);
  CHECK(s["velocity_sd_n"] == 0.0625);
  CHECK(s["satellites"] == 9);
  CHECK(s["orientation_mode"] == 7);
}

TEST_CASE("attitude: KITTI's turn from forward, left, up to east, north, up") {
  for (const auto& [roll, pitch, yaw] :
       {std::array{0.3, -0.2, 2.5}, std::array{-1.0, 0.7, -2.9}, std::array{0.0, 0.0, 0.0}}) {
    Drive drive(three, 3);
    drive.write(0, row({49, 8, 0, roll, pitch, yaw}));
    const Sample s = drive.read().samples.at(1);
    using Eigen::AngleAxisd;
    using Eigen::Vector3d;
    // The development kit's convertOxtsToPose: Rz(yaw) Ry(pitch) Rx(roll).
    const Eigen::Matrix3d theirs = (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
                                    AngleAxisd(roll, Vector3d::UnitX()))
                                       .toRotationMatrix();
    Eigen::Matrix3d ned_of_enu;
    ned_of_enu << 0, 1, 0, 1, 0, 0, 0, 0, -1;
    const Eigen::Matrix3d expected = ned_of_enu * theirs * Vector3d(1, -1, -1).asDiagonal();
    const Eigen::Matrix3d ours = (AngleAxisd(s["yaw"], Vector3d::UnitZ()) * AngleAxisd(s["pitch"], Vector3d::UnitY()) *
                                  AngleAxisd(s["roll"], Vector3d::UnitX()))
                                     .toRotationMatrix();
    CHECK((ours - expected).norm() < 1e-8);
  }
}

TEST_CASE("stamps: GPS weeks, a zone, and the folder itself") {
  const Drive drive(three, 3);
  // Friday of GPS week 1655; 15 leap seconds then.
  CHECK(drive.read({{"week", 1655}}).samples.at(0).t ==
        (5 * 86400 + 12 * 3600 + 40 * 60 + 59 + 15) * nanoseconds_per_second + 1);
  CHECK(drive.read({{"zone", 2 * 3600}}).samples.at(0).t == (59 - 2 * 3600) * nanoseconds_per_second + 1);
  const Drive flat(three, 3, "");
  CHECK(flat.read().samples.size() == 6);
}

TEST_CASE("what is missing or damaged is left out and said") {
  Drive drive(three + "2011-09-30 12:41:00.4\n2011-09-30 12:4x\n2011-09-30 12:41:02\n", 5);
  drive.write(1, row({}).substr(0, 100));
  drive.folder.write("oxts/data/0000000009.txt", row({}));
  const Oxts r = drive.read();
  CHECK(r.of("").size() == 2);
  CHECK(r.has_reported("B062 timestamps.txt:2 1 data file skipped: data/0000000001.txt: it has"));
  CHECK(r.has_reported("B062 timestamps.txt:5 1 stamp skipped: '2011-09-30 12:4x' is not a time"));
  CHECK(r.has_reported("B065 timestamps.txt:6 1 stamp skipped: there is no data/0000000005.txt"));
  CHECK(r.has_reported("B063 timestamps.txt:4 1 stamp skipped: it is not in order of time"));
  CHECK(r.has_reported("1 files have no stamp and were left out, as 0000000009.txt"));
  CHECK_THROWS_AS(drive.read({{"on_error", "stop"}}), ComponentError);
  drive.write(0, row({.lat = 91}));
  CHECK(drive.read().has_reported("a coordinate is beyond its range"));
  const Folder empty;
  CHECK_THROWS_AS(Oxts(json{{"path", empty.file("")}}), ComponentError);
}

}  // namespace kitti_test
