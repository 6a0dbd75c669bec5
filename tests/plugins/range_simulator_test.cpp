// SPDX-License-Identifier: Apache-2.0
// Plugin aiding_simulator, ranges: distances by hand, biases, noise and detours by their statistics, anchors out of reach.
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "../../plugins/aiding_simulator/simulator.hpp"
#include "bind.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"
#include "strapdown/earth.hpp"

using namespace binnacle;
using namespace binnacle::aiding_simulator;
using namespace binnacle::test;
using Eigen::Vector3d;
using Json = nlohmann::json;

namespace {

const Vector3d here(0.9, 0.2, 100);

/// An anchor that is so far north, east, down of `here`.
Json at(const Vector3d& way) {
  const Vector3d lla =
      strapdown::lla_from_ecef(strapdown::ecef_from_lla(here) + strapdown::C_en(here[0], here[1]) * way);
  return {{"lat", lla[0]}, {"lon", lla[1]}, {"height", lla[2]}};
}

struct Read {
  std::map<int, std::vector<double>> ranges;  // by anchor
  std::vector<double> errors;                 // of the truth
};

Read read(const Json& parameters, int samples, const Vector3d& angles = Vector3d::Zero(), std::uint64_t seed = 1) {
  const auto simulator = bind<AidingSimulator>({{{"range", parameters}}, {}, {}});
  const ComponentSpec spec = AidingSimulator::spec();
  std::vector<std::byte> memory(simulator->declaration().memory_bytes);
  simulator->start(seed, memory.data());
  Read all;
  const std::vector<double> fields = {here[0], here[1], here[2], 0, 0, 0, angles[0], angles[1], angles[2], 0, 0, 0};
  for (int k = 0; k < samples; ++k) {
    SampleView sample;
    sample.t = nanoseconds(k), sample.fields = fields.data();
    const auto made = binnacle::testing::TransformCaller(*simulator, spec).on(0, sample, memory.data());
    REQUIRE(made.damage.empty());
    for (const auto& emitted : made.samples) {
      if (simulator->declaration().channels[static_cast<std::size_t>(emitted.channel)].name == "truth")
        all.errors = emitted.fields;
      for (int row = 0; row < emitted.rows; ++row) {
        const auto i = static_cast<std::size_t>(2 * row);
        all.ranges[static_cast<int>(emitted.row_fields[i])].push_back(emitted.row_fields[i + 1]);
      }
    }
  }
  return all;
}

}  // namespace

TEST_CASE("aiding_simulator: ranges by hand, at a lever arm, and of anchors within reach", "[aiding_simulator]") {
  const Json anchors{{"7", at({30, 0, 0})}, {"105", at({0, 0, -40})}, {"9", at({100, 0, 0})}};
  const Read plain = read({{"anchors", anchors}}, 1);
  CHECK(plain.ranges.size() == 3);
  CHECK(std::abs(plain.ranges.at(7)[0] - 30) < 1e-8);
  CHECK(std::abs(plain.ranges.at(105)[0] - 40) < 1e-8);
  CHECK(plain.errors == std::vector<double>{0, 0, 0});
  // 10 m ahead of a body that looks south.
  const Read turned = read({{"anchors", anchors}, {"lever_arm", {10, 0, 0}}, {"reach", 100}}, 1, {0, 0, M_PI});
  CHECK(turned.ranges.size() == 2);  // 110 m are beyond
  CHECK(std::abs(turned.ranges.at(7)[0] - 40) < 1e-4);
  CHECK_THROWS_AS(read({{"anchors", {{"door", at({1, 0, 0})}}}}, 1), ComponentError);
  CHECK_THROWS_AS(read({{"anchors", Json::object()}}, 1), ComponentError);
}

TEST_CASE("aiding_simulator: ranges have the noise, the biases and the detours that are given", "[aiding_simulator]") {
  constexpr int samples = 20000;
  Json blocked = at({0, 30, 0});
  blocked["blocked"] = 0.3;
  const Read all =
      read({{"anchors", {{"1", at({30, 0, 0})}, {"2", blocked}}}, {"noise", 0.1}, {"bias", 0.5}, {"detour", 2}},
           samples);
  REQUIRE(all.errors.size() == 2);
  CHECK(all.errors[0] != all.errors[1]);
  const auto moments = [&](int anchor) {
    double mean = 0, square = 0;
    const double truth = 30 + all.errors[static_cast<std::size_t>(anchor - 1)];
    for (const double range : all.ranges.at(anchor)) mean += (range - truth) / samples;
    for (const double range : all.ranges.at(anchor)) square += (range - truth) * (range - truth) / samples;
    return std::pair(mean, square);
  };
  const auto [free_mean, free_square] = moments(1);
  CHECK(std::abs(free_mean) < 4 * 0.1 / std::sqrt(samples));
  CHECK(std::abs(free_square / 0.01 - 1) < 4 * std::sqrt(2.0 / samples));
  // A share p of exponential deviates of mean m: p m, and p · 2 m² besides the noise; four of their deviations.
  const auto [mean, square] = moments(2);
  CHECK(std::abs(mean - 0.6) < 4 * std::sqrt(0.3 * 8 - 0.36) / std::sqrt(samples));
  CHECK(std::abs(square - (2.4 + 0.01)) < 4 * std::sqrt(0.3 * 24 * 16 - 2.4 * 2.4) / std::sqrt(samples));
  for (const double range : all.ranges.at(2)) REQUIRE(range > 30 + all.errors[1] - 0.6);  // never too short
  // Biases are drawn with their deviation.
  double drawn = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const double bias =
        read({{"anchors", {{"1", at({30, 0, 0})}}}, {"bias", 0.5}}, 1, Vector3d::Zero(), seed).errors[0];
    drawn += bias * bias / 2000;
  }
  CHECK(std::abs(drawn / 0.25 - 1) < 4 * std::sqrt(2.0 / 2000));
}
