// SPDX-License-Identifier: Apache-2.0
// Plugin aiding_simulator: readings by hand, lever arms, noise and errors by their statistics, streams that nobody else moves.
#include "../../plugins/aiding_simulator/simulator.hpp"
#include "binnacle/testing.hpp"

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "bind.hpp"
#include "catch.hpp"
#include "strapdown/earth.hpp"

namespace aiding_simulator_test {

using namespace binnacle;
using namespace binnacle::aiding_simulator;
using namespace binnacle::test;
using Eigen::Vector3d;
using Json = nlohmann::json;

namespace {

constexpr double degree = M_PI / 180;

struct Body {
  Vector3d lla{54 * degree, 10 * degree, 100}, v_n{1, 2, -0.5}, angles = Vector3d::Zero(), omega = Vector3d::Zero();
};

/// Readings by channel, in the order of time.
using Readings = std::map<std::string, std::vector<std::vector<double>>>;

Readings readings(const Json& parameters, const Body& body, int samples, double step, std::uint64_t seed = 1) {
  const auto simulator = bind<AidingSimulator>({parameters, {}, {}});
  const ComponentSpec spec = AidingSimulator::spec();
  std::vector<std::byte> memory(simulator->declaration().memory_bytes);
  simulator->start(seed, memory.data());
  Readings all;
  for (int k = 0; k < samples; ++k) {
    std::vector<double> fields;
    for (const Vector3d& v : {body.lla, body.v_n, body.angles, body.omega})
      fields.insert(fields.end(), v.data(), v.data() + 3);
    SampleView sample;
    sample.t = nanoseconds(k * step), sample.fields = fields.data();
    const auto made = binnacle::testing::TransformCaller(*simulator, spec).on(0, sample, memory.data());
    REQUIRE(made.damage.empty());
    for (const auto& emitted : made.samples) {
      CHECK(emitted.t == sample.t);
      all[simulator->declaration().channels[static_cast<std::size_t>(emitted.channel)].name].push_back(emitted.fields);
    }
  }
  return all;
}

Vector3d triple(const std::vector<double>& v) { return {v.at(0), v.at(1), v.at(2)}; }

double rms(const std::vector<std::vector<double>>& samples, std::size_t field, double mean) {
  double sum = 0;
  for (const auto& sample : samples) sum += (sample[field] - mean) * (sample[field] - mean);
  return std::sqrt(sum / static_cast<double>(samples.size()));
}

}  // namespace

TEST_CASE("aiding_simulator: readings without errors, by hand", "[aiding_simulator]") {
  Body body;
  body.angles = {0, 0, 90 * degree};  // to the east: forward 2, right −1, down −0.5
  const Readings all =
      readings({{"magnetometer", {{"declination", 0}, {"inclination", 60 * degree}, {"strength", 2e-5}}},
                {"height", Json::object()},
                {"body_velocity", Json::object()},
                {"heading", {{"baseline", {0, 1, 0}}}},
                {"course", Json::object()},
                {"attitude", Json::object()}},
               body, 1, 1);
  CHECK((triple(all.at("magnetometer")[0]) - Vector3d(0, -1e-5, 2e-5 * std::sqrt(0.75))).norm() < 1e-19);
  CHECK(all.at("height")[0][0] == 100);
  CHECK((triple(all.at("body_velocity")[0]) - Vector3d(2, -1, -0.5)).norm() < 1e-14);
  CHECK(std::abs(std::abs(all.at("heading")[0][0]) - M_PI) < 1e-14);
  CHECK(std::abs(all.at("course")[0][0] - std::atan2(2, 1)) < 1e-14);
  CHECK((triple(all.at("attitude")[0]) - body.angles).norm() < 1e-14);
  for (const double error : all.at("truth")[0]) CHECK(error == 0);
}

TEST_CASE("aiding_simulator: the attitude of a system that is mounted at an angle", "[aiding_simulator]") {
  Body body;
  body.angles = {10 * degree, 0, 0};  // its right side is down
  const auto mounted = [&](const Vector3d& mounting) {
    const Json angles{mounting[0], mounting[1], mounting[2]};
    return triple(readings({{"attitude", {{"mounting", angles}}}}, body, 1, 1).at("attitude")[0]);
  };
  // Components turned about z by +90 deg: a forward vector is along the system's y, so its x is the body's left.
  CHECK((mounted({0, 0, 90 * degree}) - Vector3d(0, 10 * degree, -90 * degree)).norm() < 1e-14);
  // By +10 deg about x: the system's y is 10 deg above the body's right side.
  CHECK((mounted({10 * degree, 0, 0})).norm() < 1e-14);
}

TEST_CASE("aiding_simulator: lever arms of a vehicle that turns on its place", "[aiding_simulator]") {
  Body body;
  body.v_n.setZero();
  body.omega = strapdown::omega_ie_n(body.lla[0]) + Vector3d(0, 0, 0.2);  // level and heading north, to the right
  const Json sensors = {{"height", {{"lever_arm", {0, 0, -3}}}}, {"body_velocity", {{"lever_arm", {2, 0, 0}}}}};
  const Readings all = readings(sensors, body, 1, 1);
  CHECK(std::abs(all.at("height")[0][0] - 103) < 1e-9);
  CHECK((triple(all.at("body_velocity")[0]) - Vector3d(0, 0.4, 0)).norm() < 1e-15);  // the bow goes to the right
  CHECK_THROWS_AS(bind<AidingSimulator>({sensors, {}, {"omega_x"}}), ComponentError);
  CHECK_NOTHROW(bind<AidingSimulator>({{{"body_velocity", Json::object()}}, {}, {"omega_x"}}));
  CHECK_THROWS_AS(bind<AidingSimulator>(Setup{}), ComponentError);
}

TEST_CASE("aiding_simulator: noise has the size that is given, errors stay and are on the channel truth",
          "[aiding_simulator]") {
  const Body body;
  const Json sensors = {{"height", {{"every", 0}, {"noise", 0.3}, {"bias", 2}, {"scale", 0.1}, {"reference", 40}}},
                        {"body_velocity", {{"every", 0}, {"noise", 0.1}, {"relative", 0.05}, {"scale", 0.1}}}};
  const int samples = 20000;
  const Readings all = readings(sensors, body, samples, 1);
  const auto& truth = all.at("truth");  // height_bias, height_scale, body_velocity_scale, mount_x, …
  CHECK(truth.front() == truth.back());
  const double height = 100 + truth[0][0] + truth[0][1] * 60;
  CHECK(std::abs(rms(all.at("height"), 0, height) / 0.3 - 1) < 4 / std::sqrt(2.0 * samples));
  const double v = (1 + truth[0][2]) * body.v_n.norm();
  const double forward = (1 + truth[0][2]) * body.v_n[0];
  CHECK(std::abs(rms(all.at("body_velocity"), 0, forward) / std::hypot(0.1, 0.05 * v) - 1) <
        4 / std::sqrt(2.0 * samples));
}

TEST_CASE("aiding_simulator: errors are drawn with their deviation, once a run, and wander with their time",
          "[aiding_simulator]") {
  const Json sensors = {{"height", {{"bias", 2}, {"bias_wandering", 1}, {"bias_tau", 100}}}};
  const int runs = 2000;
  double square = 0, product = 0;
  for (int run = 0; run < runs; ++run) {
    const auto truth = readings(sensors, {}, 11, 10, static_cast<std::uint64_t>(run)).at("truth");
    square += truth.back()[0] * truth.back()[0];
    product += truth.front()[0] * truth.back()[0];
  }
  // E b² = 4 + 1, E b(0) b(τ) = 4 + 1/e; the relative deviation of a mean square is √(2/runs).
  CHECK(std::abs(square / runs / 5 - 1) < 4 * std::sqrt(2.0 / runs));
  CHECK(std::abs(product / runs / (4 + std::exp(-1)) - 1) < 4 * std::sqrt(2.5 / runs));
}

TEST_CASE("aiding_simulator: iron is added in body axes, soft iron before hard", "[aiding_simulator]") {
  Body body;
  body.angles = {0, 0, 180 * degree};
  const Readings all = readings(
      {{"magnetometer",
        {{"inclination", 0}, {"strength", 5e-5}, {"hard_iron", 1e-6}, {"soft_iron", 0.1}, {"cross_axis", 0.1}}}},
      body, 1, 1);
  const auto& e = all.at("truth")[0];  // hx hy hz sxx syy szz sxy sxz syz
  const Vector3d b = triple(all.at("magnetometer")[0]);
  CHECK((b - Vector3d(e[0] - 5e-5 * (1 + e[3]), e[1] - 5e-5 * e[6], e[2] - 5e-5 * e[7])).norm() < 1e-18);
}

TEST_CASE("aiding_simulator: no sooner than every, and no sensor moves another's noise", "[aiding_simulator]") {
  const Body body;
  const Json height = {{"every", 0.2}, {"noise", 0.3}};
  const Readings alone = readings({{"height", height}}, body, 21, 0.1);
  CHECK(alone.at("height").size() == 11);
  const Readings both =
      readings({{"height", height}, {"magnetometer", {{"every", 0}, {"noise", 1e-7}}}, {"heading", {{"bias", 0.1}}}},
               body, 21, 0.1);
  CHECK(alone.at("height") == both.at("height"));
  CHECK(both.at("magnetometer").size() == 21);
}

TEST_CASE("aiding_simulator: perfect is without any error, the noise of others as it was", "[aiding_simulator]") {
  const Body body;
  Json sensors = {{"height", {{"noise", 0.3}, {"bias", 2}, {"bias_wandering", 1}}},
                  {"body_velocity", {{"noise", 0.1}, {"misalignment", 0.1}}},
                  {"perfect", true}};
  const Readings all = readings(sensors, body, 5, 1);
  for (const auto& reading : all.at("height")) CHECK(reading[0] == 100);
  for (const auto& reading : all.at("body_velocity")) CHECK((triple(reading) - body.v_n).norm() < 1e-15);
}

}  // namespace aiding_simulator_test
