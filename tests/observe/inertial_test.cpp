// SPDX-License-Identifier: Apache-2.0
// binnacle observe on simulated drives: what theory says can be observed of inertial navigation, and when.
#include "catch.hpp"

#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace inertial_test {

using namespace binnacle::test;
using json = nlohmann::ordered_json;  // the order of blocks is that of the rows

namespace {

constexpr double earth_rate = 7.292115e-5;  // [rad/s]
constexpr double latitude = 48 * std::numbers::pi / 180;
constexpr double gravity = 9.8085;  // there, 500 m up [m/s²]

/// Position and velocity fixes once a second, a gyro of 0.1 deg/h.
const char* const still = R"~({
  "binnacle": 1, "title": "a theory",
  "sources": { "drive": { "type": "vehicle_simulator",
    "start": { "lat": "48 deg", "lon": "11 deg", "height": "500 m", "heading": 0 },
    "segments": [ { "do": "still", "duration": "300 s" } ], "imu_rate": "20 Hz",
    "gyro": { "bias": "0.1 deg/h", "bias_instability": 0, "noise": "0.002 deg/sqrt(h)", "scale": 0 },
    "accel": { "bias": "0.1 mg", "bias_instability": 0, "noise": "0.001 m/s/sqrt(h)", "scale": 0 },
    "initial_sigma": { "tilt": "0.1 deg", "heading": "2 deg" } } },
  "filters": { "ins": {
    "blocks": {
      "position":   { "type": "navigation/position", "init": { "channel": "drive.initial" } },
      "velocity":   { "type": "navigation/velocity", "init": { "channel": "drive.initial" } },
      "attitude":   { "type": "navigation/attitude", "init": { "channel": "drive.initial" } },
      "gyro_bias":  { "type": "vector", "size": 3, "unit": "rad/s", "sigma": "0.1 deg/h" },
      "accel_bias": { "type": "vector", "size": 3, "unit": "m/s^2", "sigma": "0.1 mg" } },
    "process": {
      "strapdown": { "type": "phi_error/phi_error", "input": "drive.imu",
        "blocks": { "position": "position", "velocity": "velocity", "attitude": "attitude", "gyro_bias": "gyro_bias",
                    "accel_bias": "accel_bias" },
        "gyro_noise": "0.002 deg/sqrt(h)", "accel_noise": "0.001 m/s/sqrt(h)" },
      "gyro_drift":  { "type": "random_constant", "blocks": { "x": "gyro_bias" } },
      "accel_drift": { "type": "random_constant", "blocks": { "x": "accel_bias" } } },
    "measurements": { "fix": { "channel": "drive.gnss", "stack": {
      "position": { "type": "position_fix", "blocks": { "position": "position" } },
      "velocity": { "type": "velocity_fix", "blocks": { "velocity": "velocity" } } } } } } } })~";

/// A patch that sets one value.
json at(const std::string& pointer, const json& value) {
  json patch;
  patch[json::json_pointer(pointer)] = value;
  return patch;
}

using Patches = std::vector<json>;

Patches operator+(Patches first, const Patches& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

Patches drive(const char* segments) { return {at("/sources/drive/segments", json::parse(segments))}; }

const Patches moving{at("/sources/drive/start/speed", "20 m/s")};
const Patches straight = moving + drive(R"([{"do": "straight", "duration": "300 s"}])");
const Patches rolling{at("/filters/ins/measurements/rolling", json::parse(R"({
  "type": "nhc", "channel": "drive.imu", "sigma": "0.2 m/s", "spacing": "1 s",
  "blocks": { "velocity": "velocity", "attitude": "attitude" } })"))};
const Patches known_bias{at("/filters/ins/blocks/gyro_bias/estimate", json::array()),
                         at("/sources/drive/gyro/bias", 0)};
const Patches mems{at("/sources/drive/gyro/bias", "100 deg/h"), at("/sources/drive/gyro/noise", "0.3 deg/sqrt(h)"),
                   at("/filters/ins/blocks/gyro_bias/sigma", "100 deg/h"),
                   at("/filters/ins/process/strapdown/gyro_noise", "0.3 deg/sqrt(h)")};

/// The windows of the filter.
json observed(const Patches& patches, const std::vector<std::string>& words = {}) {
  const Workbench bench;
  json config = json::parse(still);
  for (const auto& patch : patches) config.merge_patch(patch);
  bench.write("c.json", config.dump());
  std::vector<std::string> arguments{"observe", "c.json", "--json"};
  arguments.insert(arguments.end(), words.begin(), words.end());
  const auto outcome = binnacle::test::binnacle(bench, arguments);
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(outcome.out).at("filters").at("ins");
}

const json& component(const json& window, const std::string& name) { return window.at("components").at(name); }
double removed(const json& window, const std::string& name) { return component(window, name).at("removed"); }

/// The direction of that name in a list, null where there is none.
json named(const json& list, const std::string& name) {
  for (const auto& direction : list)
    if (direction.at("name") == name) return direction;
  return nullptr;
}

bool is_in_any(const json& list, const std::string& name) {
  for (const auto& direction : list)
    for (const auto& part : direction.at("parts"))
      if (part.at("component") == name) return true;
  return false;
}

/// Displacement of the second component over that of the first [SI].
double ratio(const json& direction) {
  const auto scale = [](const std::string& unit) {
    const double degree = std::numbers::pi / 180;
    return unit == "deg" ? degree : unit == "deg/h" ? degree / 3600 : 1.0;
  };
  const auto value = [&](int i) {
    const json& part = direction.at("parts").at(static_cast<std::size_t>(i));
    return part.at("displacement").get<double>() * scale(part.at("unit"));
  };
  return value(1) / value(0);
}

}  // namespace

TEST_CASE(
    "observe: at rest, heading cannot be separated from the east gyro's bias, nor tilt from the accelerometers'") {
  const json window = observed({}).at(0);
  CHECK(window.at("window") == "the whole run");
  CHECK(window.at("samples").at("fix") == 300);
  INFO(window.at("weak").dump(1));
  REQUIRE(window.at("weak").size() == 4);
  // φ̇_E = Ω cos L φ_D − δb_E stays zero, as does δv̇ = (−g φ_E, g φ_N) − δb_a.
  const json heading = named(window.at("weak"), "attitude.down with gyro_bias.y");
  REQUIRE_FALSE(heading.is_null());
  CHECK(heading.at("removed") < 0.01);
  CHECK(heading.at("removed_without_process_noise") < 0.01);
  CHECK(ratio(heading) == Approx(earth_rate * std::cos(latitude)).epsilon(0.02));
  const json roll = named(window.at("weak"), "attitude.north with accel_bias.y");
  const json pitch = named(window.at("weak"), "attitude.east with accel_bias.x");
  REQUIRE_FALSE(roll.is_null());
  REQUIRE_FALSE(pitch.is_null());
  CHECK(ratio(roll) == Approx(gravity).epsilon(0.005));
  CHECK(ratio(pitch) == Approx(-gravity).epsilon(0.005));
  CHECK(roll.at("removed") < 0.01);
  CHECK_FALSE(named(window.at("weak"), "gyro_bias.z").is_null());
  CHECK(window.at("inconsistent").empty());
  // The heading is as well known as the bias allows, no better.
  const double limit = 0.1 / 3600 / (earth_rate * std::cos(latitude));  // deg
  CHECK(component(window, "attitude.down").at("after") > 0.95 * limit);
  CHECK(component(window, "attitude.down").at("after") < 1.1 * limit);
}

TEST_CASE("observe: which gyro it is depends on the heading") {
  const json window = observed({at("/sources/drive/start/heading", "90 deg")}).at(0);
  const json heading = named(window.at("weak"), "attitude.down with gyro_bias.x");
  REQUIRE_FALSE(heading.is_null());
  CHECK(ratio(heading) == Approx(earth_rate * std::cos(latitude)).epsilon(0.02));
}

TEST_CASE("observe: at rest with the gyro's bias known, heading is seen through the earth's rate") {
  const json window = observed(known_bias).at(0);
  CHECK(removed(window, "attitude.down") > 0.99);
  CHECK_FALSE(is_in_any(window.at("weak"), "attitude.down"));
  CHECK(component(window, "attitude.down").at("known_after_s") > 10);
  CHECK_FALSE(window.at("components").contains("gyro_bias.y"));
}

TEST_CASE("observe: at rest, a MEMS gyro is too weak for that") {
  const json window = observed(mems + known_bias).at(0);
  CHECK(removed(window, "attitude.down") < 0.25);
  CHECK(component(window, "attitude.down").at("removed_without_process_noise") > 0.99);
  CHECK(component(window, "attitude.down").at("known_after_s").is_null());
  const json heading = named(window.at("weak"), "attitude.down");
  REQUIRE_FALSE(heading.is_null());
  const json unknown = observed(mems).at(0);
  CHECK(removed(unknown, "attitude.down") < 0.1);
  CHECK(is_in_any(unknown.at("weak"), "attitude.down"));
}

TEST_CASE("observe: straight ahead at constant speed, heading is seen no better than at rest") {
  const json window = observed(straight).at(0);
  const json heading = named(window.at("weak"), "attitude.down with gyro_bias.y");
  REQUIRE_FALSE(heading.is_null());
  CHECK(heading.at("removed") < 0.01);
  CHECK(ratio(heading) == Approx(earth_rate * std::cos(latitude)).epsilon(0.02));
  CHECK(window.at("inconsistent").empty());
  CHECK(removed(observed(mems + straight).at(0), "attitude.down") < 0.1);
}

TEST_CASE("observe: in turns and accelerations heading is seen, from when they begin") {
  const Patches faster = drive(R"([{"do": "still", "duration": "60 s"},
    {"do": "accelerate", "to": "20 m/s", "acceleration": "1 m/s^2"}, {"do": "straight", "duration": "30 s"}])");
  const Patches turn = moving + drive(R"([{"do": "straight", "duration": "30 s"},
    {"do": "turn", "angle": "90 deg", "rate": "6 deg/s"}, {"do": "straight", "duration": "30 s"}])");
  const json accelerated = observed(faster).at(0), turned = observed(turn).at(0);
  CHECK(component(accelerated, "attitude.down").at("known_after_s") > 60);
  CHECK(component(accelerated, "attitude.down").at("known_after_s") < 75);
  CHECK(component(turned, "attitude.down").at("known_after_s") > 30);
  CHECK(component(turned, "attitude.down").at("known_after_s") < 40);
  // With a MEMS gyro the heading at the begin of the manoeuvre; that at the start is a matter of the gyro's bias meanwhile.
  const json mems_accelerated = observed(mems + faster, {"--window", "60:"}).at(0);
  const json mems_turned = observed(mems + turn, {"--window", "30:"}).at(0);
  CHECK_FALSE(named(observed(mems + faster).at(0).at("weak"), "attitude.down with gyro_bias.z").is_null());
  CHECK(component(mems_accelerated, "attitude.down").at("known_after_s") < 15);
  CHECK(component(mems_turned, "attitude.down").at("known_after_s") < 10);
  for (const json& window : {accelerated, turned, mems_accelerated, mems_turned})
    CHECK(removed(window, "attitude.down") > 0.95);
  for (const json& window : {accelerated, turned}) CHECK_FALSE(is_in_any(window.at("weak"), "attitude.down"));
}

TEST_CASE("observe: a vehicle that rolls without slipping shows its heading straight ahead, and not at rest") {
  const json window = observed(mems + straight + rolling).at(0);
  CHECK(removed(window, "attitude.down") > 0.9);
  CHECK_FALSE(is_in_any(window.at("weak"), "attitude.down"));
  CHECK(component(window, "attitude.down").at("by").at("rolling") > 0.9 * removed(window, "attitude.down"));
  const json at_rest = observed(mems + rolling).at(0);
  CHECK(at_rest.at("samples").at("rolling") == 0);
  CHECK(removed(at_rest, "attitude.down") < 0.1);
}

TEST_CASE("observe: windows are looked at by themselves, each with what was known at its begin") {
  Patches setting_off = drive(R"([{"do": "still", "duration": "60 s"},
    {"do": "accelerate", "to": "20 m/s", "acceleration": "1 m/s^2"}, {"do": "straight", "duration": "60 s"}])");
  setting_off.push_back(at("/evaluate/windows", json::parse(R"({"setting off": ["start+60 s", "85 s"]})")));
  const json windows =
      observed(mems + setting_off, {"--window", ":60", "--window", "setting off", "--window", "85 s:"});
  REQUIRE(windows.size() == 3);
  CHECK(windows[0].at("window") == ":60");
  CHECK(windows[0].at("samples").at("fix") == 60);  // that of the start came before it
  CHECK(windows[1].at("window") == "setting off");
  CHECK(windows[1].at("from_s") == Approx(60).epsilon(1e-9));
  CHECK(windows[1].at("to_s") == Approx(85).epsilon(1e-9));
  CHECK(windows[1].at("samples").at("fix") == 25);
  CHECK(removed(windows[0], "attitude.down") < 0.1);
  CHECK(removed(windows[1], "attitude.down") > 0.8);
  CHECK(removed(windows[2], "attitude.down") < removed(windows[1], "attitude.down"));
  // What was known at a window's begin is what the one before it left, and what noise has added since.
  CHECK(component(windows[2], "attitude.down").at("before").get<double>() <
        0.5 * component(windows[1], "attitude.down").at("before").get<double>());
}

TEST_CASE("observe: what is left at the start is what a smoother leaves there") {
  const Workbench bench;
  json config = json::parse(still);
  for (const auto& patch : mems) config.merge_patch(patch);
  config.merge_patch(json::parse(R"({
    "sources": { "drive": { "segments": [ { "do": "still", "duration": "20 s" },
                                          { "do": "accelerate", "to": "20 m/s", "acceleration": "1 m/s^2" } ] } },
    "filters": { "ins": { "smoother": "fixed_interval" } },
    "reference": [ { "channel": "drive.truth", "blocks": { "ins/attitude": ["roll", "pitch", "yaw"] } } ],
    "evaluate": { "metrics": [ "ins.smoothed/attitude.down/sigma at 0 s", "ins.smoothed/attitude.east/sigma at 0 s" ] } })"));
  bench.write("c.json", config.dump());
  const auto run = binnacle::test::binnacle(bench, {"run", "c.json", "--json"});
  const auto seen = binnacle::test::binnacle(bench, {"observe", "c.json", "--json"});
  INFO(run.err << seen.err);
  REQUIRE(run.status == 0);
  REQUIRE(seen.status == 0);
  const json metrics = json::parse(run.out).at("metrics"), window = json::parse(seen.out).at("filters").at("ins").at(0);
  for (const std::string name : {"attitude.down", "attitude.east"})
    CHECK(component(window, name).at("after").get<double>() ==
          Approx(metrics.at("ins.smoothed/" + name + "/sigma at 0 s").at("value").get<double>()).epsilon(1e-6));
}

TEST_CASE("observe: a considered component counts as if it were estimated, and is called so") {
  const json estimated = observed(straight).at(0);
  const json considered = observed(straight + Patches{at("/filters/ins/blocks/gyro_bias/consider", {"y"})}).at(0);
  CHECK(component(considered, "gyro_bias.y").at("considered") == true);
  CHECK_FALSE(component(estimated, "gyro_bias.y").contains("considered"));
  for (const std::string name : {"attitude.down", "gyro_bias.y", "velocity.north"})
    CHECK(removed(considered, name) == Approx(removed(estimated, name)).epsilon(0.01));
}

TEST_CASE("observe: paper 000, the azimuth is seen through the ship's rolling") {
  const Workbench bench;
  const auto align = [&](const std::vector<std::string>& words) {
    std::vector<std::string> arguments{"observe", BINNACLE_TEST_PROJECT "/configs/transfer_alignment/base.json",
                                       "--json"};
    arguments.insert(arguments.end(), words.begin(), words.end());
    const auto outcome = binnacle::test::binnacle(bench, arguments);
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    return json::parse(outcome.out).at("filters").at("align").at(0);
  };
  const std::vector<std::string> no_roll{"--set", R"(/sources/ship/motion/roll={"tones":[]})"};
  std::vector<std::string> no_turns = no_roll;
  no_turns.insert(no_turns.end(), {"--set", R"(/sources/ship/motion/pitch={"tones":[]})"});
  const json rolling_ship = align({}), without_roll = align(no_roll), level = align(no_turns);
  // Match alone: the sum of azimuth and mounting, which is half of the variance of either.
  CHECK(rolling_ship.at("weak").empty());
  CHECK(removed(rolling_ship, "attitude.down") > 0.95);
  CHECK(removed(without_roll, "attitude.down") < 0.85);
  CHECK(removed(level, "attitude.down") < 0.65);
  const json azimuth = named(level.at("weak"), "attitude.down with mounting.z");
  REQUIRE_FALSE(azimuth.is_null());
  CHECK(azimuth.at("removed") < 0.25);
}

}  // namespace inertial_test
