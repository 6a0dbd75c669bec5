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
#include <numbers>
#include <numeric>
#include <random>
#include <set>

#include "assignment.hpp"
#include "common/example.hpp"

using namespace binnacle;
using example::is_near;

namespace {

constexpr std::size_t targets = 3;

struct Detection {
  double range, bearing;
};

Detection seen_at(double north, double east) { return {std::hypot(north, east), std::atan2(east, north)}; }

/// Where the filter believes a target to be, and the standard deviations of that: north, east [m].
struct Belief {
  Eigen::Vector2d position, sigma = {20, 20};
};
using Beliefs = std::array<Belief, targets>;

const Beliefs usual{{{{2000, 0}}, {{2000, 200}}, {{-1500, 1500}}}};

class Radar {
 public:
  testing::PortStates ports(const Beliefs& beliefs) const {
    testing::PortStates states(part_.ports.size());
    for (std::size_t i = 0; i < targets; ++i) {
      const auto& [position, sigma] = beliefs[i];
      states[i] = {part_.ports[i].block.get(), {position[0], position[1]}, sigma};
    }
    return states;
  }
  static testing::Given given(const std::vector<Detection>& detections) {
    testing::Given given;
    given.sample.t = nanoseconds(1);
    given.sample.rows = static_cast<int>(detections.size());
    given.sample.row_fields = detections.empty() ? nullptr : &detections.front().range;
    given.sample.available = true;
    return given;
  }
  testing::Measured scan(const std::vector<Detection>& detections, const Beliefs& beliefs = usual) const {
    return caller_.linearize(given(detections), ports(beliefs), caller_.fresh_memory());
  }
  const testing::MeasurementCaller& caller() const { return caller_; }

 private:
  parts::Part<MeasurementModel> part_ = parts::measurement(example::composition(), "tracks", "scan");
  testing::MeasurementCaller caller_{*part_.model, part_.type->spec};
};

using Keys = std::vector<std::int64_t>;

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
    std::set<std::size_t> columns_used;
    for (std::size_t i = 0; i < rows; ++i) columns_used.insert(found[i]);
    CHECK(columns_used.size() == rows);
  }
}

TEST_CASE("each detection goes to its target, in whatever order they come, and the rows bear its number") {
  const auto scanned = Radar().scan({seen_at(-1490, 1505), seen_at(2004, 195)});
  REQUIRE(scanned.result);
  CHECK(scanned.damage.empty());
  REQUIRE(scanned.keys == Keys{2, 2, 3, 3});
  // r is what leads from the estimate to the detection: along the line of sight, and across it, to the right.
  CHECK(is_near(scanned.residual[0], std::hypot(2004, 195) - std::hypot(2000, 200), 1e-9));
  CHECK(scanned.residual[1] < 0);  // 195 m east of the radar instead of 200 m: further to the left
  CHECK(scanned.H[0].isZero());
  const double range = std::hypot(2004, 195), bearing_sigma = 0.5 * std::numbers::pi / 180;  // of tracker.json
  CHECK(is_near(scanned.R(0, 0), 25, 1e-9));
  CHECK(is_near(scanned.R(1, 1), std::pow(range * bearing_sigma, 2), 1e-9));
}

TEST_CASE("clutter makes no rows, and a target without detection none either") {
  const Radar radar;
  const auto nothing = radar.scan({seen_at(500, 500), seen_at(-3000, 10), seen_at(2000, -300)});
  CHECK(nothing.result);
  CHECK(nothing.keys.empty());
  CHECK(radar.scan({}).keys.empty());
  CHECK(radar.scan({seen_at(500, 500), seen_at(2001, 3), seen_at(-3000, 10)}).keys == Keys{1, 1});
  CHECK_FALSE(radar.scan({{-5, 0}}).result);
  CHECK_FALSE(radar.scan(std::vector<Detection>(65, {1000, 0})).result);
}

TEST_CASE("association is by what P makes plausible, not by distance") {
  const Radar radar;
  // 60 m east of the first target, 140 m west of the second: nearer to the first.
  const std::vector<Detection> between{seen_at(2000, 60)};
  CHECK(radar.scan(between).keys == Keys{1, 1});
  // But the first is known to 1 m east, and the second is hardly known along that axis.
  Beliefs beliefs = usual;
  beliefs[0].sigma[1] = 1, beliefs[1].sigma[1] = 100;
  CHECK(radar.scan(between, beliefs).keys == Keys{2, 2});
}

TEST_CASE("all detections together decide, not the best pair first") {
  Beliefs beliefs = usual;
  beliefs[1].position = {2000, 40};
  // The nearest pair of all is the second target with the first detection, which would leave 110 m for the other two.
  const auto scanned = Radar().scan({seen_at(2000, 35), seen_at(2000, 110)}, beliefs);
  REQUIRE(scanned.keys == Keys{1, 1, 2, 2});
  CHECK(is_near(scanned.residual[1], 35, 0, 1));
  CHECK(is_near(scanned.residual[3], 70, 0, 1));
}

TEST_CASE("H is the derivative of range and bearing, across the line where bearings jump as well") {
  Beliefs beliefs = usual;
  beliefs[0].position = {-2000, 3};
  for (auto& belief : beliefs) belief.sigma = {10, 10};
  const std::vector<Detection> detections{seen_at(2010, 190), seen_at(-1490, 1505), seen_at(-2003, -4)};
  const Radar radar;
  const auto scanned = radar.scan(detections, beliefs);
  REQUIRE(scanned.keys == Keys{1, 1, 2, 2, 3, 3});
  CHECK(is_near(std::abs(scanned.residual[1]), 7, 0.01));
  const auto given = Radar::given(detections);
  const auto ports = radar.ports(beliefs);
  auto complaints = check_measurement(radar.caller(), given, ports, {}, {.relative = 1e-6, .steps = {1e-2}});
  complaints.add_all(check_values(radar.caller(), given, ports, {}));
  INFO(complaints.text());
  CHECK(complaints.empty());
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
