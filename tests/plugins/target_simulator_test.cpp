// SPDX-License-Identifier: Apache-2.0
// Plugin target_simulator: azimuths against truth and the legs, the spread of starts and increments over many seeds.
#include "../../plugins/target_simulator/simulator.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "binnacle/bind.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"

namespace target_simulator_test {

using namespace binnacle;
using namespace binnacle::target_simulator;
using nlohmann::json;

namespace {

std::unique_ptr<TargetSimulator> bound(const json& config) {
  return binnacle::testing::bind<TargetSimulator>({config});
}

struct Point {
  Time t;
  std::vector<double> bearing, truth;
};

std::vector<Point> all_of(const TargetSimulator& source, std::uint64_t seed) {
  const binnacle::testing::SourceCaller caller(source);
  auto memory = caller.fresh_memory(seed);
  std::vector<Point> points;
  for (;;) {
    const auto next = caller.next(memory.data());
    REQUIRE(next.damage.empty());
    if (next.status == SourceStatus::end) return points;
    if (next.sample.channel == 0)
      points.push_back({next.sample.t, next.sample.fields, {}});
    else
      points.back().truth = next.sample.fields;
  }
}

json config(double sigma) {
  return {{"duration", "40 s"},
          {"rate", "0.5 Hz"},
          {"sigma", sigma},
          {"target",
           {{"position", {1000, 100}},
            {"velocity", {2, -1}},
            {"position_sigma", {300, 20}},
            {"velocity_sigma", {0.5, 3}},
            {"q", 0.4}}},
          {"observer", {-10, 5}},
          {"legs", {{{"duration", "10 s"}, {"velocity", {0, 10}}}, {{"duration", "10 s"}, {"velocity", {-8, 0}}}}}};
}

}  // namespace

TEST_CASE("target_simulator: azimuths are those of truth from the legs", "[target_simulator]") {
  const auto source = bound(config(0));
  const auto points = all_of(*source, 3);
  REQUIRE(points.size() == 21);
  for (const Point& point : points) {
    const double t = seconds(point.t);
    const Eigen::Vector2d observer(-10 - 8 * std::max(0.0, t - 10), 5 + 10 * std::min(t, 10.0));
    CHECK(std::abs(point.bearing[1] - observer[0]) < 1e-9);
    CHECK(std::abs(point.bearing[2] - observer[1]) < 1e-9);
    CHECK(std::abs(point.bearing[0] - std::atan2(point.truth[1] - observer[1], point.truth[0] - observer[0])) < 1e-12);
  }
}

TEST_CASE("target_simulator: starts, increments and bearings are spread as specified", "[target_simulator]") {
  constexpr int runs = 2000;
  const auto source = bound(config(0.02));
  Eigen::Vector4d start = Eigen::Vector4d::Zero();
  Eigen::Matrix2d increments = Eigen::Matrix2d::Zero();
  double angle = 0, count = 0;
  for (int run = 0; run < runs; ++run) {
    const auto points = all_of(*source, static_cast<std::uint64_t>(run));
    const auto& first = points.front().truth;
    const Eigen::Vector4d off(first[0] - 1000, first[1] - 100, first[2] - 2, first[3] + 1);
    start += off.cwiseAbs2() / runs;
    for (std::size_t i = 1; i < points.size(); ++i) {
      const auto &a = points[i - 1].truth, &b = points[i].truth;
      for (std::size_t k = 0; k < 2; ++k) {
        const Eigen::Vector2d w(b[k] - a[k] - 2 * a[k + 2], b[k + 2] - a[k + 2]);
        increments += w * w.transpose();
        ++count;
      }
      const auto& z = points[i].bearing;
      const double noise = z[0] - std::atan2(b[1] - z[2], b[0] - z[1]);
      angle += noise * noise;
    }
  }
  // Within five standard errors.
  const auto is_near = [](double variance, double expected, double samples) {
    return std::abs(variance / expected - 1) < 5 * std::sqrt(2 / samples);
  };
  CHECK(is_near(start[0], 300 * 300, runs));
  CHECK(is_near(start[1], 20 * 20, runs));
  CHECK(is_near(start[2], 0.5 * 0.5, runs));
  CHECK(is_near(start[3], 3 * 3, runs));
  increments /= count;
  const double q = 0.4 * 0.4, dt = 2;
  CHECK(is_near(increments(0, 0), q * dt * dt * dt / 3, count));
  CHECK(is_near(increments(1, 1), q * dt, count));
  CHECK(is_near(increments(0, 1), q * dt * dt / 2, count / 2));
  CHECK(is_near(angle / (count / 2), 0.02 * 0.02, count / 2));
}

}  // namespace target_simulator_test
