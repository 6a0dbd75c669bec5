// SPDX-License-Identifier: Apache-2.0
// Plugin aiding_simulator, ranges and their differences: distances by hand, biases, noise and detours by their statistics, anchors out of reach.
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

namespace range_simulator_test {

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
  std::map<int, std::vector<double>> ranges;  // or differences, by anchor
  std::vector<double> errors;                 // of the truth
  double reference = 0;                       // of differences
};

Read read(const Json& parameters, int samples, const Vector3d& angles = Vector3d::Zero(), std::uint64_t seed = 1,
          const char* sensor = "range") {
  const auto simulator = bind<AidingSimulator>({{{sensor, parameters}}, {}, {}});
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
        const std::size_t width = emitted.row_fields.size() / static_cast<std::size_t>(emitted.rows);
        const auto i = static_cast<std::size_t>(row) * width;
        all.ranges[static_cast<int>(emitted.row_fields[i])].push_back(emitted.row_fields[i + width - 1]);
        if (width == 3) all.reference = emitted.row_fields[i + 1];
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

namespace {

Read differences(const Json& parameters, int samples, const Vector3d& angles = Vector3d::Zero()) {
  return read(parameters, samples, angles, 1, "range_difference");
}

}  // namespace

TEST_CASE("aiding_simulator: differences of ranges by hand, anchor less reference", "[aiding_simulator]") {
  const Json anchors{{"7", at({30, 0, 0})}, {"105", at({0, 0, -40})}, {"9", at({100, 0, 0})}};
  const Read plain = differences({{"anchors", anchors}, {"reference", 105}}, 1);
  CHECK(plain.ranges.size() == 2);
  CHECK(plain.reference == 105);
  CHECK(std::abs(plain.ranges.at(7)[0] + 10) < 1e-8);
  CHECK(std::abs(plain.ranges.at(9)[0] - 60) < 1e-8);
  // 10 m ahead of a body that looks south: 40, 110 and hypot(40, 10).
  const Json ahead{{"anchors", anchors}, {"reference", 7}, {"lever_arm", {10, 0, 0}}};
  const Read turned = differences(ahead, 1, {0, 0, M_PI});
  CHECK(std::abs(turned.ranges.at(9)[0] - 70) < 1e-4);
  CHECK(std::abs(turned.ranges.at(105)[0] - (std::hypot(40, 10) - 40)) < 1e-4);
  Json near = ahead;
  near["reach"] = 100;
  CHECK(differences(near, 1, {0, 0, M_PI}).ranges.size() == 1);
  near["reference"] = 9;  // beyond reach: nothing to compare with
  CHECK(differences(near, 1, {0, 0, M_PI}).ranges.empty());
  CHECK_THROWS_AS(differences({{"anchors", anchors}, {"reference", 8}}, 1), ComponentError);
  CHECK_THROWS_AS(differences({{"anchors", {{"7", at({30, 0, 0})}}}, {"reference", 7}}, 1), ComponentError);
}

TEST_CASE("aiding_simulator: differences have the errors of two arrivals, and share the reference's",
          "[aiding_simulator]") {
  constexpr int samples = 20000;
  const Read all = differences({{"anchors", {{"1", at({30, 0, 0})}, {"2", at({0, 30, 0})}, {"3", at({0, 0, 30})}}},
                                {"reference", 2},
                                {"noise", 0.1},
                                {"bias", 0.5}},
                               samples);
  REQUIRE(all.errors.size() == 3);  // of the reference, 1, 3
  const double mean_1 = all.errors[1] - all.errors[0], mean_3 = all.errors[2] - all.errors[0];
  REQUIRE(std::abs(mean_1 - mean_3) > 0.01);
  double square = 0, product = 0, sum = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    const double a = all.ranges.at(1)[i] - mean_1, b = all.ranges.at(3)[i] - mean_3;
    sum += a / samples, square += a * a / samples, product += a * b / samples;
  }
  // Variances 2 s^2 and covariance s^2; four of their deviations: sqrt(2) 2 s^2 and sqrt(4 + 1) s^2.
  CHECK(std::abs(sum) < 4 * std::sqrt(0.02 / samples));
  CHECK(std::abs(square / 0.02 - 1) < 4 * std::sqrt(2.0 / samples));
  CHECK(std::abs(product - 0.01) < 4 * std::sqrt(5.0 / samples) * 0.01);
}

}  // namespace range_simulator_test
