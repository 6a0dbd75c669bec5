// SPDX-License-Identifier: Apache-2.0
// Segment errors: the metric against KITTI's measure written out in Python, its settings, and what has no segment.
#include "catch.hpp"

#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace segments_test {

using namespace binnacle::test;
using binnacle::test::Contains;
using nlohmann::json;

namespace {

/// A drive that inertial sensors alone follow, with truth at 20 Hz in a file beside it. No length is a whole number of its
/// poses: where one ends would then be a matter of the last bit.
const char* const drive = R"~({
  "binnacle": 1,
  "sources": { "van": {
    "type": "vehicle_simulator", "start": { "lat": "49 deg", "lon": "8.4 deg", "height": "115 m", "heading": "70 deg", "speed": "14.37 m/s" },
    "segments": [ { "do": "straight", "duration": "12 s" }, { "do": "turn", "angle": "80 deg", "duration": "9 s" },
                  { "do": "climb", "height": "8 m", "duration": "14 s" }, { "do": "turn", "angle": "-100 deg", "duration": "12 s" },
                  { "do": "straight", "duration": "20 s" } ],
    "imu_rate": "100 Hz", "truth_rate": "20 Hz", "gnss_rate": 0,
    "gyro": { "bias": "100 deg/h", "noise": "1 deg/sqrt(h)" }, "accel": { "bias": "1 mg" },
    "initial_sigma": { "position": "2 m", "velocity": "0.3 m/s", "tilt": "0.1 deg", "heading": "4 deg" } } },
  "filters": { "ins": {
    "blocks": { "position": { "type": "position", "init": { "channel": "van.initial" } },
                "velocity": { "type": "velocity", "init": { "channel": "van.initial" } },
                "attitude": { "type": "attitude", "init": { "channel": "van.initial" } } },
    "process": { "strapdown": { "type": "phi_error", "input": "van.imu", "gyro_noise": "1 deg/sqrt(h)", "accel_noise": "0.03 m/s/sqrt(h)",
      "blocks": { "position": "position", "velocity": "velocity", "attitude": "attitude" } } } } },
  "sinks": { "truth": { "type": "csv_writer", "input": "van.truth", "path": "true_poses.csv", "columns": {
    "lat": { "unit": "rad" }, "lon": { "unit": "rad" }, "height": { "unit": "m" },
    "roll": { "unit": "rad" }, "pitch": { "unit": "rad" }, "yaw": { "unit": "rad" } } } },
  "reference": { "channel": "van.truth", "blocks": { "ins/position": ["lat", "lon", "height"], "ins/attitude": ["roll", "pitch", "yaw"] } },
  "evaluate": { "metrics": ["ins/position.segments/translation", "ins/position.segments/rotation",
                            { "metric": "ins/position.segments/rotation", "unit": "rad/m" }] }
})~";

struct Segments {
  double count = 0, translation = 0, rotation = 0;  // %, deg/m
};

Segments by_python(const Workbench& bench, const std::string& settings) {
  const std::string words = std::string(BINNACLE_TEST_PYTHON) + " '" + BINNACLE_TEST_PROJECT +
                            "/tests/sdk/kitti_measure.py' '" + bench.path("out/ins.csv") + "' '" +
                            bench.path("true_poses.csv") + "' " + settings + " 2>&1";
  FILE* const pipe = popen(words.c_str(), "r");
  std::string text;
  for (int c = 0; (c = fgetc(pipe)) != EOF;) text += static_cast<char>(c);
  INFO(text);
  REQUIRE(pclose(pipe) == 0);
  Segments segments;
  std::istringstream(text) >> segments.count >> segments.translation >> segments.rotation;
  return segments;
}

json ran(const Workbench& bench, std::vector<std::string> options = {}) {
  bench.write("drive.json", drive);
  options.insert(options.begin(), {"run", "drive.json", "--out", "out", "--summary", "summary.json"});
  const auto outcome = binnacle::test::binnacle(bench, options);
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(read_file(bench.path("summary.json")));
}

double figure(const json& summary, const char* statistic) {
  return summary.at("metrics").at(std::string("ins/position.segments/") + statistic).at("value").get<double>();
}

std::string said_of(const Workbench& bench, const std::string& set) {
  bench.write("drive.json", drive);
  const auto outcome = binnacle::test::binnacle(bench, {"run", "drive.json", "--set", set});
  return outcome.err;
}

}  // namespace

TEST_CASE("segment errors are KITTI's measure") {
  for (const auto& [settings, arguments] :
       {std::pair<std::string, std::string>{"{}", "0.1 10 100 200 300 400 500 600 700 800"},
        {R"({"lengths": ["50 m", "0.21 km"], "every": "0.25 s", "start_every": 3})", "0.25 3 50 210"}}) {
    INFO(settings);
    const Workbench bench;
    const json summary =
        ran(bench, {"--set", "/evaluate/segments=" + settings, "--set",
                    R"(/evaluate/metrics=["ins/position.segments/translation","ins/position.segments/rotation"])"});
    const Segments expected = by_python(bench, arguments);
    REQUIRE(expected.count > 100);
    REQUIRE(expected.translation > 1);
    INFO(expected.translation << " %, " << expected.rotation << " deg/m");
    // Over a kilometre north turns by 1e-4, which the metric leaves out.
    CHECK(std::abs(figure(summary, "translation") / expected.translation - 1) < 1e-3);
    CHECK(std::abs(figure(summary, "rotation") / expected.rotation - 1) < 1e-3);
  }
}

TEST_CASE("segment errors: a span of evaluate, and units") {
  const Workbench bench;
  const double whole = figure(ran(bench), "translation");
  CHECK(figure(ran(bench, {"--set", "/evaluate/until=30 s"}), "translation") != whole);
  const json summary = ran(bench);
  CHECK(summary.at("metrics").at("ins/position.segments/translation").at("unit") == "%");
  // The text has them too.
  const std::string text = binnacle::test::binnacle(bench, {"run", "drive.json"}).out;
  const auto line = text.find("ins/position.segments/translation");
  INFO(text);
  REQUIRE(line != std::string::npos);
  std::istringstream rest(text.substr(line));
  std::string name, unit;
  double value = 0;
  rest >> name >> value >> unit;
  CHECK(std::abs(value / whole - 1) < 1e-3);
  CHECK(unit == "%");
}

TEST_CASE("segment errors: what has none says so") {
  const Workbench bench;
  CHECK_THAT(said_of(bench, R"(/evaluate/segments={"lengths": ["5 km"]})"),
             Contains("B125") && Contains("has no segment: the 671 poses of the path are not 5000 m long"));
  CHECK_THAT(said_of(bench, "/evaluate/metrics=ins/velocity.segments/translation"),
             Contains("/evaluate/metrics") && Contains("filter 'ins' has no segments 'velocity.segments'") &&
                 Contains("there are: position.segments"));
  CHECK_THAT(said_of(bench, "/evaluate/metrics=ins/position.segments/rms"), Contains("B027"));
  CHECK_THAT(said_of(bench, R"(/reference/blocks={"ins/position": ["lat", "lon", "height"]})"),
             Contains("a position in metres and an attitude whose references give all outputs of both"));
  CHECK_THAT(said_of(bench, R"(/evaluate/segments={"attitude": "atitude"})"),
             Contains("no filter has an attitude 'atitude'; did you mean 'attitude'?"));
  CHECK_THAT(said_of(bench, R"(/evaluate/segments={"lenghts": ["5 km"]})"), Contains("did you mean 'lengths'"));
  CHECK_THAT(said_of(bench, R"(/evaluate/segments={"lengths": []})"), Contains("needs one length at least"));
  CHECK_THAT(said_of(bench, R"(/evaluate/segments={"lengths": ["0 m"]})"), Contains("/evaluate/segments/lengths/0"));
}

}  // namespace segments_test
