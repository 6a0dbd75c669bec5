// SPDX-License-Identifier: Apache-2.0
// The plugin's own tests: the association, the measurement model as tracker.json composes it, and fifty runs.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include <binnacle/parts.hpp>

#include "assignment.hpp"
#include "common/example.hpp"

using namespace binnacle;
using example::is_near;

namespace {

constexpr int targets = 3, ports = 8, most_rows = 2 * targets;

struct Detection {
  double range, bearing;
};

Detection seen_at(double north, double east) { return {std::hypot(north, east), std::atan2(east, north)}; }

/// Where the filter believes its targets to be, and P of the three positions together.
struct Belief {
  std::array<Eigen::Vector2d, targets> position{{{2000, 0}, {2000, 200}, {-1500, 1500}}};
  Eigen::MatrixXd P = 400 * Eigen::MatrixXd::Identity(most_rows, most_rows);
};

struct Scanned {
  Result result;
  int rows = 0;
  Eigen::VectorXd residual = Eigen::VectorXd::Zero(most_rows);
  std::array<Eigen::MatrixXd, targets> H;
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(most_rows, most_rows);
  std::array<std::int64_t, most_rows> keys{};
};

Scanned scan(const MeasurementModel& model, const std::vector<Detection>& detections, const Belief& belief,
             bool is_linearized = true) {
  Scanned scanned;
  std::array<const double*, ports> x{};
  std::array<MatrixView, ports> H;
  std::array<int, ports> first_row;
  first_row.fill(-1);
  for (std::size_t i = 0; i < targets; ++i) {
    x[i] = belief.position[i].data();
    scanned.H[i] = Eigen::MatrixXd::Zero(most_rows, 2);
    H[i] = {scanned.H[i].data(), most_rows, 2, most_rows};
    first_row[i] = 2 * static_cast<int>(i);
  }
  MeasurementInput in;
  in.sample.rows = static_cast<int>(detections.size());
  in.sample.row_fields = detections.empty() ? nullptr : &detections.front().range;
  in.x = x.data();
  in.P = {belief.P.data(), most_rows, first_row.data()};
  MeasurementOutput out;
  out.residual = {scanned.residual.data(), most_rows};
  if (is_linearized) out.H = H.data();
  out.R = {scanned.R.data(), most_rows, most_rows, most_rows};
  out.row_keys = scanned.keys;
  scanned.result = model.linearize(in, out);
  scanned.rows = out.rows;
  return scanned;
}

std::shared_ptr<const MeasurementModel> model() {
  return parts::measurement(*example::compose(), "tracks", "scan").model;
}

}  // namespace

TEST_CASE("the assignment is the cheapest of all") {
  std::mt19937 random(7);
  for (int trial = 0; trial < 500; ++trial) {
    const std::size_t rows = 1 + random() % 4, columns = rows + random() % 3;
    Assignment<4, 6> assignment(rows, columns);
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < columns; ++j) assignment.cost(i, j) = random() % 20;
    const auto cost_of = [&](const auto& column_of) {
      double sum = 0;
      for (std::size_t i = 0; i < rows; ++i) sum += assignment.cost(i, column_of[i]);
      return sum;
    };
    std::array<std::size_t, 6> order;
    std::iota(order.begin(), order.end(), 0u);
    double least = cost_of(order);
    do least = std::min(least, cost_of(order));
    while (std::next_permutation(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(columns)));
    auto found = assignment.solve();
    CHECK(cost_of(found) == least);
    std::sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(rows));
    CHECK(std::adjacent_find(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(rows)) ==
          found.begin() + static_cast<std::ptrdiff_t>(rows));
  }
}

TEST_CASE("each detection goes to its target, in whatever order they come, and the rows bear its number") {
  const Belief belief;
  const Scanned scanned = scan(*model(), {seen_at(-1490, 1505), seen_at(2004, 195)}, belief);
  REQUIRE(scanned.result);
  REQUIRE(scanned.rows == 4);
  CHECK(std::vector<std::int64_t>(scanned.keys.begin(), scanned.keys.begin() + 4) ==
        std::vector<std::int64_t>{2, 2, 3, 3});
  // r is what leads from the estimate to the detection: along the line of sight, and across it, to the right.
  CHECK(is_near(scanned.residual[0], std::hypot(2004, 195) - std::hypot(2000, 200), 1e-9));
  CHECK(scanned.residual[1] < 0);  // 195 m east of the radar instead of 200 m: further to the left
  CHECK(scanned.H[0].isZero());
  const double range = std::hypot(2004, 195), bearing_sigma = 0.5 * std::acos(-1) / 180;  // of tracker.json
  CHECK(is_near(scanned.R(0, 0), 25, 1e-9));
  CHECK(is_near(scanned.R(1, 1), std::pow(range * bearing_sigma, 2), 1e-9));
}

TEST_CASE("clutter makes no rows, and a target without detection none either") {
  const Belief belief;
  const Scanned nothing = scan(*model(), {seen_at(500, 500), seen_at(-3000, 10), seen_at(2000, -300)}, belief);
  CHECK(nothing.result);
  CHECK(nothing.rows == 0);
  CHECK(scan(*model(), {}, belief).rows == 0);
  const Scanned one = scan(*model(), {seen_at(500, 500), seen_at(2001, 3), seen_at(-3000, 10)}, belief);
  CHECK(one.rows == 2);
  CHECK(one.keys[0] == 1);
  CHECK_FALSE(scan(*model(), {{-5, 0}}, belief).result);
  CHECK_FALSE(scan(*model(), std::vector<Detection>(65, {1000, 0}), belief).result);
}

TEST_CASE("association is by what P makes plausible, not by distance") {
  // 60 m east of the first target, 140 m west of the second: nearer to the first.
  const std::vector<Detection> between{seen_at(2000, 60)};
  Belief belief;
  CHECK(scan(*model(), between, belief).keys[0] == 1);
  // But the first is known to 1 m east, and the second is hardly known along that axis.
  belief.P(1, 1) = 1, belief.P(3, 3) = 100 * 100;
  const Scanned scanned = scan(*model(), between, belief);
  REQUIRE(scanned.rows == 2);
  CHECK(scanned.keys[0] == 2);
}

TEST_CASE("all detections together decide, not the best pair first") {
  Belief belief;
  belief.position = {{{2000, 0}, {2000, 40}, {-1500, 1500}}};
  // The nearest pair of all is the second target with the first detection, which would leave 75 m for the other two.
  const Scanned scanned = scan(*model(), {seen_at(2000, 35), seen_at(2000, 110)}, belief);
  REQUIRE(scanned.rows == 4);
  CHECK(is_near(scanned.residual[1], 35, 0, 1));
  CHECK(is_near(scanned.residual[3], 70, 0, 1));
}

TEST_CASE("H is the derivative of range and bearing, across the line where bearings jump as well") {
  Belief belief;
  belief.position[0] = {-2000, 3};
  const std::vector<Detection> detections{seen_at(2010, 190), seen_at(-1490, 1505), seen_at(-2003, -4)};
  const auto measurement = model();
  const Scanned scanned = scan(*measurement, detections, belief);
  REQUIRE(scanned.rows == 6);
  CHECK(is_near(std::abs(scanned.residual[1]), 7, 0.01));
  for (std::size_t i = 0; i < targets; ++i)
    for (int axis = 0; axis < 2; ++axis) {
      Belief up = belief, down = belief;
      up.position[i][axis] += 0.01, down.position[i][axis] -= 0.01;
      const Eigen::VectorXd slope =
          -(scan(*measurement, detections, up).residual - scan(*measurement, detections, down).residual) / 0.02;
      INFO("target " << i + 1 << ", axis " << axis << ":\n" << slope << "\nis\n" << scanned.H[i].col(axis));
      CHECK((slope - scanned.H[i].col(axis)).cwiseAbs().maxCoeff() < 1e-7);
    }
  CHECK(scan(*measurement, detections, belief, false).residual == scanned.residual);  // to the bit without Jacobians
}

TEST_CASE("errors of fifty runs among misses and clutter are as large as the filter believes") {
  const auto figures = example::study();
  for (const char* block : {"tracks/car", "tracks/bus", "tracks/truck", "tracks/truck_velocity"}) {
    const auto& figure = figures.at(std::string(block) + "/nees");
    INFO(block << " NEES " << figure.mean << " in " << figure.runs << " runs");
    CHECK(figure.runs == 50);
    CHECK(std::abs(figure.mean - 2) < 2.58 * std::sqrt(2 * 2.0 / figure.runs));  // 99 %
  }
  for (const char* track : {"tracks/car.norm/p95", "tracks/bus.norm/p95", "tracks/truck.norm/p95"}) {
    INFO(track << " " << figures.at(track).mean << " m");
    CHECK(figures.at(track).mean < 20);  // m; 2 km at 0.5 deg are 17 m
  }
}
