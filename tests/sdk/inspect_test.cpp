// SPDX-License-Identifier: Apache-2.0
// inspect, with files as people have them: other names, dates, decimal commas, the wrong file.
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "command.hpp"

namespace inspect_test {

using namespace binnacle::test;
using nlohmann::json;

namespace {

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

Outcome inspect(const Workbench& bench, std::vector<std::string> files) {
  files.insert(files.begin(), "inspect");
  return binnacle::test::binnacle(bench, files);
}

/// Positions a quarter of a second apart, under any header; `cell` writes a number, `label` a time.
template <class Cell, class Label>
std::string fixes(const std::string& header, const std::string& delimiter, Cell cell, Label label) {
  std::string text = header;
  for (int i = 0; i < 80; ++i) {
    text += label(i);
    for (const double value : {48 + 1e-6 * i, 11 + 1e-5 * i * i / 80, 500 + std::sin(0.1 * i), 1.0, 0.5, -0.25})
      text += delimiter + cell(value);
    text += "\n";
  }
  return text;
}

std::string point(double value) { return fmt::format("{:.7f}", value); }
std::string comma(double value) {
  std::string text = point(value);
  text[text.find('.')] = ',';
  return text;
}
std::string seconds_of(int i) { return fmt::format("{:.2f}", 0.25 * i); }

/// The proposed source of `file`; a config is proposed as soon as there is an IMU beside it.
json proposed(const Workbench& bench, const std::string& file) {
  std::string imu = "t_s,gx_radps,gy_radps,gz_radps,ax_mps2,ay_mps2,az_mps2\n";
  for (int i = 0; i < 2000; ++i)
    imu += fmt::format("{:.2f},{:.6f},0.001,0.002,0.01,{:.5f},9.81\n", 0.01 * i, 1e-3 * std::sin(i), 0.1 * std::cos(i));
  bench.write("imu.csv", imu);
  const auto outcome = inspect(bench, {"imu.csv", file, "--write", "proposed.json", "--force"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  CHECK(binnacle::test::binnacle(bench, {"check", "proposed.json"}).err.empty());
  return json::parse(read_file(bench.path("proposed.json"))).at("sources").at(file.substr(0, file.find('.')));
}

/// One a second, each line after `stamp`; up to `late` hundredths of a second behind.
std::string sentences(const std::string& stamp, int late = 1) {
  std::string text;
  for (int i = 0; i < 20; ++i) {
    const std::string body =
        fmt::format("GPRMC,1200{:02d}.{:02d},A,4807.0380,N,01131.0000,E,2.0,84.4,230825,,,A", i, i * i % late);
    unsigned sum = 0;
    for (const char c : body) sum ^= static_cast<unsigned char>(c);
    text += fmt::format("{}${}*{:02X}\r\n", stamp, body, sum);
  }
  return text;
}

}  // namespace

TEST_CASE(
    "inspect: every channel of a config's source is looked at, and a steady simulated velocity is none that hangs") {
  const Workbench bench;
  bench.write("drive.json", R"({"binnacle": 1, "sources": {"drive": {"type": "vehicle_simulator",
    "start": {"lat": "48 deg", "lon": "11 deg", "height": "500 m"},
    "segments": [{"do": "still", "duration": "5 s"}, {"do": "accelerate", "to": "15 m/s", "acceleration": "1.5 m/s^2"},
      {"do": "straight", "duration": "30 s"}]}}, "filters": {}})");
  const auto outcome = inspect(bench, {"drive.json"});
  INFO(outcome.err << outcome.out);
  REQUIRE(outcome.status == 0);
  for (const char* channel : {"drive.imu", "drive.gnss", "drive.truth"}) CHECK(has(outcome.out, channel));
  CHECK_FALSE(has(outcome.out, "velocity_held"));
  REQUIRE(inspect(bench, {"drive.json", "--write", "extended.json"}).status == 0);
  CHECK(binnacle::test::binnacle(bench, {"check", "extended.json"}).status == 0);
}

TEST_CASE("inspect: a proposed config that was edited is not replaced, unless --force is given") {
  const Workbench bench;
  bench.write("drive.json", R"({"binnacle": 1, "sources": {"drive": {"type": "vehicle_simulator",
    "start": {"lat": "48 deg", "lon": "11 deg", "height": "500 m"},
    "segments": [{"do": "straight", "duration": "5 s"}]}}, "filters": {}})");
  REQUIRE(inspect(bench, {"drive.json", "--write", "my.json"}).status == 0);
  const std::string proposal = read_file(bench.path("my.json"));
  REQUIRE(inspect(bench, {"drive.json", "--write", "my.json"}).status == 0);  // the same text
  bench.write("my.json", proposal + " ");
  const auto refused = inspect(bench, {"drive.json", "--write", "my.json"});
  CHECK(refused.status == 2);
  CHECK(has(refused.err, "'my.json' exists already and differs from the proposal"));
  CHECK(read_file(bench.path("my.json")) == proposal + " ");
  REQUIRE(inspect(bench, {"drive.json", "--write", "my.json", "--force"}).status == 0);
  CHECK(read_file(bench.path("my.json")) == proposal);
}

TEST_CASE("inspect: a config's units may be quantities") {
  const Workbench bench;
  std::string text = "t_ms,lat,ax\n";
  for (int i = 0; i < 50; ++i) text += fmt::format("{},{},{}\n", 250 * i, 480000000 + i, i % 7);
  bench.write("data.csv", text);
  bench.write("data.json", R"({"binnacle": 1, "sources": {"data": {"type": "csv", "path": "data.csv",
    "time": {"column": "t_ms", "unit": "ms"}, "columns": {"lat": {"column": "lat", "unit": "1e-7 deg"},
    "fx": {"column": "ax", "unit": "-1 g", "kind": "rate"}}}}, "filters": {}})");
  const auto outcome = inspect(bench, {"data.json"});
  INFO(outcome.err);
  CHECK(outcome.status == 0);
  CHECK(has(outcome.out, "lat [1e-7 deg], fx [-1 g]"));
}

TEST_CASE("inspect: labels that are dates are times") {
  const Workbench bench;
  bench.write("gnss.csv", fixes("time,latitude,longitude,altitude,vn,ve,vd\n", ",", point,
                                [](int i) { return fmt::format("2025-08-28T12:00:{:05.2f}Z", 0.25 * i); }));
  const auto outcome = inspect(bench, {"gnss.csv"});
  CHECK(has(outcome.out, "80 samples in 19.75 s, one every 0.25 s"));
  CHECK(has(outcome.out, "dates and times of day"));
  const auto source = proposed(bench, "gnss.csv");
  CHECK(source.at("time") == json{{"column", "time"}, {"format", "iso8601"}});
}

TEST_CASE("inspect: labels that are neither numbers nor dates are a warning") {
  const Workbench bench;
  bench.write("gnss.csv", fixes("time,latitude,longitude,altitude,vn,ve,vd\n", ",", point,
                                [](int i) { return fmt::format("12:00:{:05.2f}", 0.25 * i); }));
  const auto outcome = inspect(bench, {"gnss.csv"});
  CHECK(has(outcome.out, "80 of 80 labels are no number"));
  CHECK_FALSE(has(outcome.out, "No warnings"));
}

TEST_CASE("inspect: decimal commas, with a header and without") {
  const Workbench bench;
  const auto label = [](int i) { return comma(0.25 * i); };
  bench.write("gnss.csv", fixes("t_s;lat_deg;lon_deg;height_m;vn_mps;ve_mps;vd_mps\n", ";", comma, label));
  const auto outcome = inspect(bench, {"gnss.csv"});
  CHECK(has(outcome.out, "80 samples in 19.75 s, one every 0.25 s"));
  const auto source = proposed(bench, "gnss.csv");
  CHECK(source.at("decimal") == ",");
  CHECK(source.at("delimiter") == ";");
  bench.write("bare.csv", fixes("", ";", comma, label));
  CHECK(has(inspect(bench, {"bare.csv"}).out, "80 samples in 19.75 s"));
}

TEST_CASE("inspect: a velocity up is one down with the other sign") {
  const Workbench bench;
  for (const std::string name : {"vel_u", "v_up_mps"}) {
    bench.write("gnss.csv", fixes("t_s,lat,lon,height,vel_n,vel_e," + name + "\n", ",", point, seconds_of));
    const auto source = proposed(bench, "gnss.csv");
    CHECK(source.at("columns").at("vd").at("unit") == "-1 m/s");
    CHECK(source.at("columns").at("vd").at("column") == name);
  }
}

TEST_CASE("inspect: comments that begin with a per cent sign") {
  const Workbench bench;
  bench.write("gnss.csv", "% a logger\n% version 2\n" + fixes("t_s,lat,lon,height,vn,ve,vd\n", ",", point, seconds_of));
  const auto source = proposed(bench, "gnss.csv");
  CHECK(source.at("comment") == "%");
  CHECK(source.at("columns").at("lat").at("column") == "lat");
}

TEST_CASE("inspect: a receiver's file is known by its content") {
  const Workbench bench;
  bench.write("log.txt", sentences(""));
  bench.write("stamped.log", sentences("2025-08-23 12:00:00 "));
  for (const char* file : {"log.txt", "stamped.log"}) {
    const auto outcome = inspect(bench, {file});
    INFO(outcome.err);
    CHECK(has(outcome.out, "20 samples  lat [rad], lon [rad]"));
    CHECK(has(outcome.out, "labels are the time that the source gives"));
  }
}

TEST_CASE("inspect: a receiver's file gets no remedy of a text file") {
  const Workbench bench;
  bench.write("log.nmea", sentences("", 60));
  const auto outcome = inspect(bench, {"log.nmea"});
  CHECK(has(outcome.out, "labels scatter"));
  CHECK_FALSE(has(outcome.out, "No warnings"));
  CHECK_FALSE(has(outcome.out, "config:"));
}

TEST_CASE("inspect: files that it can not look at are refused, with what they are") {
  const Workbench bench;
  const auto refused = [&](const std::string& file, const std::string& why) {
    const auto outcome = inspect(bench, {file});
    INFO(file << ": " << outcome.err);
    CHECK(outcome.status == 5);
    CHECK(has(outcome.err, why));
  };
  bench.write("site.05o",
              "     2.11           OBSERVATION DATA    G (GPS)             RINEX VERSION / TYPE\n"
              " 05  4  2  0  0  0.0000000  0  2G 1G 2\n  2.1 3.1\n  2.2 3.2\n");
  refused("site.05o", "is a RINEX file");
  bench.write("photo.csv", std::string("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16));
  refused("photo.csv", "neither text nor UBX");
  bench.write("notes.md", "# Notes\n| a | b |\n|---|---|\n| one | two |\n");
  refused("notes.md", "there are no rows of numbers");
  refused(".", "is a folder");
}

TEST_CASE("inspect: what a file lacks for a filter is named") {
  const Workbench bench;
  bench.write("gnss.csv", fixes("t_s,lat,lon,height,a1,a2,a3\n", ",", point, seconds_of));
  const auto imu_only = inspect(bench, {"gnss.csv", "--write", "x.json"});
  CHECK(imu_only.status == 1);
  CHECK(has(imu_only.err, "no channel has wx wy wz fx fy fz"));
  std::string imu = "t_s,gx,gy,gz,ax,ay,az\n";
  for (int i = 0; i < 100; ++i) imu += fmt::format("{:.2f},0.{},0.1,0.2,0,0,9.8\n", 0.01 * i, i);
  bench.write("imu.csv", imu);
  const auto outcome = inspect(bench, {"gnss.csv", "imu.csv", "--write", "x.json", "--force"});
  CHECK(outcome.status == 1);
  CHECK(has(outcome.err, "no channel has lat lon height vn ve vd; 'gnss' lacks vn ve vd"));
}

TEST_CASE("inspect: columns whose names say nothing are named as such") {
  const Workbench bench;
  std::string text = "t_s,alpha,beta\n";
  for (int i = 0; i < 50; ++i) text += fmt::format("{:.2f},{},{}\n", 0.1 * i, i % 7, i % 5);
  bench.write("other.csv", text);
  CHECK(has(inspect(bench, {"other.csv"}).out, "no column has a known name"));
}

TEST_CASE("inspect: a position without a header is none of a sensor's") {
  const Workbench bench;
  bench.write("kf.txt", fixes("", " ", point, seconds_of));
  const auto outcome = inspect(bench, {"kf.txt"});
  CHECK(has(outcome.out, "lat [deg?], lon [deg?], height [m?]"));
  CHECK_FALSE(has(outcome.out, "wx ["));
}

TEST_CASE("inspect: of lines of several kinds none is taken for a sensor's") {
  const Workbench bench;
  std::string text;
  for (int i = 0; i < 40; ++i)
    text += fmt::format("uwb {0:.2f} 1.5 {1} 0.1\nodo {0:.2f} 0.1 0.2 0.{1} 0.3 9.8 0.{1} 2\n", 0.1 * i, i % 9);
  bench.write("robot.txt", text);
  const auto outcome = inspect(bench, {"robot.txt"});
  CHECK(has(outcome.out, "lines are of several kinds"));
  CHECK_FALSE(has(outcome.out, "wx ["));
  CHECK_FALSE(has(outcome.out, "invalid_rows"));
}

TEST_CASE("inspect: a config's lever arm is compared with what turning shows, in the filter's axes") {
  const Workbench bench;
  const std::string config = R"({"binnacle": 1, "sources": {"drive": {"type": "vehicle_simulator", "imu_kind": "rate",
      "start": {"lat": "48 deg", "lon": "11 deg", "height": "500 m", "heading": "30 deg"},
      "segments": [{"do": "still", "duration": "20 s"}, {"do": "accelerate", "to": "12 m/s", "acceleration": "1.5 m/s^2"},
        {"do": "turn", "angle": "90 deg", "rate": "15 deg/s"}, {"do": "turn", "angle": "-120 deg", "rate": "-12 deg/s"},
        {"do": "accelerate", "to": "6 m/s", "acceleration": "-1.5 m/s^2"}, {"do": "turn", "angle": "170 deg", "rate": "25 deg/s"},
        {"do": "accelerate", "to": 0, "acceleration": "-2 m/s^2"}], "repeat": 4, "roll_gradient": "4 deg/g",
      "gnss": {"velocity_sigma": "0.03 m/s", "lever_arm": ["-1.2 m", "0.3 m", "-0.8 m"]}}},
    "transforms": {"turned": {"type": "rotate_axes", "input": "drive.imu", "yaw": "90 deg"}},
    "filters": {"ins": {"process": {"strapdown": {"input": "turned"}},
      "derived": {"antenna": {"type": "lever_arm", "lever_arm": [X, "-1.2 m", "-0.8 m"]},
                  "axle": {"type": "lever_arm_velocity", "lever_arm": [9, 9, 9]}},
      "measurements": {"fix": {"channel": "drive.gnss", "stack": {"position": {"blocks": {"position": "antenna"}}}},
                       "nhc": {"channel": "drive.truth", "blocks": {"velocity": "axle"}}}}}})";
  const auto looked_at = [&](const std::string& x) {
    std::string text = config;
    bench.write("drive.json", text.replace(text.find('X'), 1, x));
    const auto outcome = inspect(bench, {"drive.json", "--json"});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    std::vector<json> found;
    const json report = json::parse(outcome.out);
    for (const json& each : report.at("findings"))
      if (each.at("kind") == "stated_lever_arm") found.push_back(each);
    return found;
  };
  // yaw of 90 deg: x' = -y, y' = x. What no fix is bound to is not compared.
  const auto right = looked_at(R"("-0.3 m")");
  REQUIRE(right.size() == 1);
  INFO(right[0].at("text"));
  CHECK(right[0].at("severity") == "finding");
  const auto wrong = looked_at("3.7");
  REQUIRE(wrong.size() == 1);
  CHECK(wrong[0].at("severity") == "warning");
  CHECK(wrong[0].at("value").get<double>() > 3);
  CHECK(has(wrong[0].at("text"), "/filters/ins/derived/antenna has [3.70, -1.20, -0.80] m"));
}

}  // namespace inspect_test
