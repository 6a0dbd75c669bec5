// SPDX-License-Identifier: Apache-2.0
// binnacle observe where a filter grows sure of what nothing shows: linearized about estimates that corrections move.
#include "catch.hpp"

#include <cmath>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace consistency_test {

using namespace binnacle::test;
using nlohmann::json;

namespace {

/// A vehicle that knows its speed and that it rolls straight ahead. Nothing in that shows its heading: turned as a whole, with
/// its velocity, it would see the same. H depends on velocity and attitude; corrections move one against the other.
const char* const dead_reckoning = R"~({
  "binnacle": 1, "title": "dead reckoning",
  "sources": { "drive": { "type": "vehicle_simulator",
    "start": { "lat": "48 deg", "lon": "11 deg", "heading": 0, "speed": "10 m/s" },
    "segments": [ { "do": "straight", "duration": "60 s" } ], "imu_rate": "20 Hz",
    "gyro": { "bias": "10 deg/h", "bias_instability": 0, "noise": "0.1 deg/sqrt(h)", "scale": 0 },
    "accel": { "bias": "1 mg", "bias_instability": 0, "noise": "0.03 m/s/sqrt(h)", "scale": 0 },
    "initial_sigma": { "tilt": "0.1 deg", "heading": "20 deg", "velocity": "2 m/s" } } },
  "filters": { "ins": {
    "blocks": {
      "position":   { "type": "navigation/position", "init": { "channel": "drive.initial" } },
      "velocity":   { "type": "navigation/velocity", "init": { "channel": "drive.initial" } },
      "attitude":   { "type": "navigation/attitude", "init": { "channel": "drive.initial" } },
      "gyro_bias":  { "type": "vector", "size": 3, "unit": "rad/s", "sigma": "10 deg/h" },
      "accel_bias": { "type": "vector", "size": 3, "unit": "m/s^2", "sigma": "1 mg" } },
    "process": {
      "strapdown": { "type": "phi_error/phi_error", "input": "drive.imu",
        "blocks": { "position": "position", "velocity": "velocity", "attitude": "attitude", "gyro_bias": "gyro_bias",
                    "accel_bias": "accel_bias" },
        "gyro_noise": "0.1 deg/sqrt(h)", "accel_noise": "0.03 m/s/sqrt(h)" },
      "gyro_drift":  { "type": "random_constant", "blocks": { "x": "gyro_bias" } },
      "accel_drift": { "type": "random_constant", "blocks": { "x": "accel_bias" } } },
    "measurements": {
      "rolling": { "type": "nhc", "channel": "drive.imu", "sigma": "0.1 m/s", "spacing": "1 s",
                   "blocks": { "velocity": "velocity", "attitude": "attitude" } },
      "wheel": { "type": "odometer", "channel": "drive.truth", "sigma": "0.1 m/s",
                 "blocks": { "velocity": "velocity", "attitude": "attitude" } } } } } })~";

json observed(const std::vector<std::string>& words) {
  const Workbench bench;
  bench.write("c.json", dead_reckoning);
  std::vector<std::string> arguments{"observe", "c.json", "--json"};
  arguments.insert(arguments.end(), words.begin(), words.end());
  const auto outcome = binnacle::test::binnacle(bench, arguments);
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(outcome.out).at("filters").at("ins");
}

const json* part(const json& direction, const std::string& name) {
  for (const auto& candidate : direction.at("parts"))
    if (candidate.at("component") == name) return &candidate;
  return nullptr;
}

/// The direction in which the vehicle is turned as a whole.
const json* turned(const json& list) {
  for (const auto& direction : list)
    if (part(direction, "attitude.down") && part(direction, "velocity.east")) return &direction;
  return nullptr;
}

}  // namespace

TEST_CASE(
    "observe: an extended filter that has corrected a large error knows a heading that nothing shows, and is named") {
  for (const char* const seed : {"1", "2", "3", "4", "5"}) {
    INFO("seed " << seed);
    const json window = observed({"--seed", seed}).at(0);
    REQUIRE(window.at("inconsistent").size() == 1);
    const json* const direction = turned(window.at("inconsistent"));
    REQUIRE(direction);
    CHECK(direction->at("removed") < 0.01);
    CHECK(direction->at("claimed") > 0.6);
    CHECK(direction->at("since_s") < 10);
    // A turn by φ moves the velocity by φ × v̂, v̂ as it was first estimated: 10 m/s, with 2 m/s of error.
    const double angle = part(*direction, "attitude.down")->at("displacement").get<double>() * std::acos(-1) / 180;
    CHECK(part(*direction, "velocity.east")->at("displacement").get<double>() / angle == Approx(10).epsilon(0.6));
    CHECK_FALSE(turned(window.at("weak")));
  }
}

TEST_CASE("observe: the same filter without errors to correct stays as unsure as it is, and is consistent") {
  const json window = observed({"--set", "/sources/drive/perfect=true"}).at(0);
  CHECK(window.at("inconsistent").empty());
  const json* const direction = turned(window.at("weak"));
  REQUIRE(direction);
  CHECK(direction->at("removed") < 0.01);
  const double angle = part(*direction, "attitude.down")->at("displacement").get<double>() * std::acos(-1) / 180;
  CHECK(part(*direction, "velocity.east")->at("displacement").get<double>() / angle == Approx(10).epsilon(0.01));
}

TEST_CASE("observe: samples that a gate or the config left out count on neither path") {
  const json windows = observed({"--set", "/filters/ins/measurements/wheel/gate={\"probability\":0.5,\"by\":\"row\"}",
                                 "--set", "/filters/ins/measurements/rolling/gate={\"probability\":0.5,\"by\":\"row\"}",
                                 "--set", "/filters/ins/measurements/wheel/recover=false", "--set",
                                 "/filters/ins/measurements/wheel/withhold=[[\"20 s\",\"30 s\"]]", "--set",
                                 "/sources/drive/initial_sigma/velocity=0.1", "--window", "10:50"});
  const json& window = windows.at(0);
  CHECK(window.contains("inconsistent"));  // so every sample was found again
  CHECK(window.at("samples").at("wheel") < 300);
  CHECK(window.at("samples").at("wheel") > 50);
  CHECK(window.at("samples").at("rolling") > 5);
}

TEST_CASE("observe: what the text says is what the figures say, and --out leaves them for the page") {
  const Workbench bench;
  bench.write("c.json", dead_reckoning);
  const auto outcome = binnacle::test::binnacle(bench, {"observe", "c.json", "--out", "out"});
  REQUIRE(outcome.status == 0);
  const json summary = json::parse(read_file(bench.path("out/summary.json")));
  const json& window = summary.at("filters").at("ins").at("observability").at(0);
  for (const auto& list : {window.at("weak"), window.at("inconsistent")})
    for (const auto& direction : list)
      CHECK(outcome.out.find(direction.at("name").get<std::string>()) != std::string::npos);
  CHECK(outcome.out.find("INCONSISTENT") != std::string::npos);
  CHECK(outcome.out.find("attitude.down") != std::string::npos);
  CHECK(std::filesystem::exists(bench.path("out/report.html")));
  CHECK(std::filesystem::exists(bench.path("out/run.nc")));
}

TEST_CASE("observe: windows that mean nothing are usage errors, with what there is") {
  const Workbench bench;
  json config = json::parse(dead_reckoning);
  config["evaluate"] = {{"windows", {{"outage", {"20 s", "30 s"}}}}};
  bench.write("c.json", config.dump());
  const auto refused = [&](const std::string& window, const std::string& text) {
    const auto outcome = binnacle::test::binnacle(bench, {"observe", "c.json", "--window", window});
    INFO(outcome.err);
    CHECK(outcome.status == 2);
    CHECK(outcome.err.find(text) != std::string::npos);
  };
  refused("outag", "there is no window 'outag'; did you mean 'outage'?");
  refused("30:20", "the window '30:20' ends before it begins");
  refused("start*3:", "'start*3' is not a time");
  refused("3 m:", "unit 'm' is not a time");
  const auto later = binnacle::test::binnacle(bench, {"observe", "c.json", "--window", "100:200"});
  CHECK(later.status == 0);
  CHECK(later.out.find("Filter ins is in none of the windows") != std::string::npos);
}

}  // namespace consistency_test
