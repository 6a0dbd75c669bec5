// SPDX-License-Identifier: Apache-2.0
// The plugin's own tests: each model as balloon.json composes it, called in process, and a whole flight.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>
#endif

#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <binnacle/parts.hpp>
#include <binnacle/session.hpp>
#include <binnacle/testing.hpp>

using namespace binnacle;

using testing::rows_of;

namespace {

/// balloon.json with this build's library: CMakeLists.txt sets CONFIG and PLUGIN.
std::shared_ptr<const Composition> composition() {
  LoadOptions options;
  options.sets = {std::string("/plugins/0=") + std::getenv("PLUGIN")};
  return Composition::load(std::getenv("CONFIG"), options);
}

/// id, north, east; in the order of Bearings::spec().
const std::vector<double> landmarks{1, 2000, 500, 2, -900, 1500, 7, 300, -2500};

double bearing_to(int landmark, double north, double east) {
  const auto at = static_cast<std::size_t>(3 * landmark);
  return std::atan2(landmarks[at + 2] - east, landmarks[at + 1] - north);
}

}  // namespace

TEST_CASE("a bearing goes to the landmark of its number, and H is its derivative") {
  const auto composed = composition();
  const auto part = parts::measurement(*composed, "flight", "bearings");
  const testing::MeasurementCaller bearings(*part.model, part.type->spec);
  const testing::PortStates ports{{part.ports[0].block.get(), {100, -50}, 10.0}};
  const std::vector<double> sighted{7, bearing_to(2, 100, -50) + 0.01, 1, bearing_to(0, 100, -50), 5, 0.3};
  const std::vector<SampleView> auxiliary{rows_of(landmarks, 3, 0)};
  const testing::Given given{rows_of(sighted, 2, nanoseconds(1.0)), auxiliary};

  const auto seen = bearings.linearize(given, ports, bearings.fresh_memory());
  REQUIRE(seen.result);
  CHECK(seen.damage.empty());
  REQUIRE(seen.keys == std::vector<std::int64_t>{7, 1});  // there is no landmark 5
  CHECK(std::abs(seen.residual[0] - 0.01) < 1e-12);
  CHECK(std::abs(seen.residual[1]) < 1e-12);

  auto complaints = check_measurement(bearings, given, ports, bearings.fresh_memory(), {.relative = 1e-6});
  complaints.add_all(check_values(bearings, given, ports, bearings.fresh_memory()));
  complaints.add_all(testing::check_covariance(seen.R));
  INFO(complaints.text());
  CHECK(complaints.empty());
}

TEST_CASE("without landmarks there is nothing to see") {
  const auto composed = composition();
  const auto part = parts::measurement(*composed, "flight", "bearings");
  const testing::MeasurementCaller bearings(*part.model, part.type->spec);
  const testing::PortStates ports{{part.ports[0].block.get(), {100, -50}, 10.0}};
  const std::vector<double> sighted{7, 0.3};
  const std::vector<SampleView> nothing_yet{SampleView{}};
  const auto seen = bearings.linearize({rows_of(sighted, 2, 0), nothing_yet}, ports, bearings.fresh_memory());
  CHECK(seen.result.refusal == Refusal::unsupported);
}

TEST_CASE("the balloon goes with the reported wind") {
  const auto composed = composition();
  const auto part = parts::process(*composed, "flight", "drift");
  const double wind[] = {3, -5};
  SampleView report;
  report.fields = wind;
  report.available = true;
  const std::vector<SampleView> auxiliary{report};
  const testing::ProcessCaller drift(*part.model, part.type->spec, auxiliary);
  const testing::PortStates ports{{part.ports[0].block.get(), {100, -50}, 10.0}};
  const Step step{0, nanoseconds(2.0), 2, {}};

  const auto moved = drift.propagate(ports, step, drift.fresh_memory());
  REQUIRE(moved.result);
  CHECK(moved.x_plus[0] == std::vector<double>{106, -60});
  CHECK(std::abs(drift.Q(ports, moved)(0, 0) - 8) < 1e-12);  // (2 m/√s)² 2 s

  auto complaints = check_transition(drift, ports, step, drift.fresh_memory(), {.relative = 1e-6});
  complaints.add_all(check_values(drift, ports, step, drift.fresh_memory()));
  INFO(complaints.text());
  CHECK(complaints.empty());
}

TEST_CASE("a flight in the wind: the position is found, a wrong landmark is refused alone, the missing wind is noted") {
  Session session(composition());
  const auto wind = session.channel("wind"), sightings = session.channel("sightings");
  session.push(session.channel("landmarks"), rows_of(landmarks, 3, 0));
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  double north = 120, east = -80;
  for (int second = 0; second < 60; ++second) {
    const Time t = nanoseconds(second);
    const double blows[] = {4, -3};
    if (second == 10) session.push(wind, no_time, t, blows);
    if (second >= 10) north += 4, east -= 3;
    std::vector<double> rows;
    for (int i = 0; i < 3; ++i) {
      rows.push_back(landmarks[static_cast<std::size_t>(3 * i)]);
      rows.push_back(bearing_to(i, north, east) + 0.2 * std::numbers::pi / 180 * normal(random));
    }
    if (second > 30) rows[1] += 0.3;  // the pilot mistakes another hill for landmark 1
    session.push(sightings, rows_of(rows, 2, t));
  }
  double found[2], sigma[2];
  session.read(session.block("position"), found);
  session.read_sigma(session.block("position"), sigma);
  CHECK(std::abs(found[0] - north) < 4 * sigma[0]);
  CHECK(std::abs(found[1] - east) < 4 * sigma[1]);
  const auto counts = session.counts(session.measurement("bearings"));
  CHECK(counts.by_outcome[static_cast<int>(Outcome::accepted)] == 60);
  CHECK(counts.rows_left_out == 29);
  const auto notes = session.notes(session.filter("flight"));
  REQUIRE(notes.items().size() == 1);
  CHECK(notes.items()[0].message.find("no wind has been reported yet, it is taken as calm (9 times)") !=
        std::string::npos);
}
