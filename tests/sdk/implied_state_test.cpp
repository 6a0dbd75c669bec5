// SPDX-License-Identifier: Apache-2.0
// Implied states of a running filter: a block's value implied by one measurement, against a Kalman filter written out here.
#include "catch.hpp"

#include <cmath>
#include <sstream>

#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "csv_columns.hpp"
#include "results/results.hpp"

namespace implied_state_test {

using namespace binnacle::test;
using nlohmann::json;

namespace {

constexpr double fixes[] = {0.1, 0.2, 0.15, 0.3, 0.25};

/// The good config with a sensor that has an offset.
const char* const with_implied_state = R"~({
  "extends": "good.json",
  "filters": { "walk": {
    "blocks": { "offset": { "type": "vector", "size": 1, "unit": "m", "init": { "x": 0.05 }, "sigma": 0.5 } },
    "process": { "stays": { "type": "random_constant", "blocks": { "x": "offset" } } },
    "measurements": { "seen": { "blocks": { "bias": "offset" }, "gate": null } },
    "implied_states": { "direct": { "measurement": "seen", "block": "place" } } } },
  "reference": [ { "channel": "truth", "blocks": { "walk/place": ["x"], "walk/direct": ["x"] } } ],
  "evaluate": { "metrics": ["walk/direct.x/at 1 s", "walk/direct.x/at 2 s", "walk/direct.x/final", "walk/direct.x/sigma",
                            "walk/direct.x/sigma at 2 s", "walk/direct/nees at 2 s"] },
  "covariance": { "duration": "4 s", "channels": { "fix": { "interval": "1 s" } },
                  "metrics": ["walk/direct/sigma", "walk/direct/own sigma at 2 s"] }
})~";

struct Expected {
  double value, sigma;
};

/// z − the offset as it is held before z, and the variance of that: of the offset before z, and of z's noise.
std::vector<Expected> by_hand() {
  std::vector<Expected> implied_states;
  Eigen::Vector2d x(0, 0.05);
  Eigen::Matrix2d P = Eigen::Vector2d(1, 0.25).asDiagonal();
  const Eigen::RowVector2d H(1, 1);
  for (const double z : fixes) {
    if (!implied_states.empty()) P(0, 0) += 0.01;
    implied_states.push_back({z - x[1], std::sqrt(P(1, 1) + 0.01)});
    const Eigen::Vector2d K = P * H.transpose() / (H * P * H.transpose() + 0.01);
    x += K * (z - H * x);
    P = (Eigen::Matrix2d::Identity() - K * H) * P;
  }
  return implied_states;
}

json ran(const Workbench& bench, const std::string& config, std::vector<std::string> options = {}) {
  options.insert(options.begin(), {"run", config, "--summary", "summary.json"});
  const auto outcome = binnacle::test::binnacle(bench, options);
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(read_file(bench.path("summary.json")));
}

}  // namespace

TEST_CASE("an implied state is scored against a reference, with its own sigma") {
  const Workbench bench;
  bench.write("implied_state.json", with_implied_state);
  const auto summary = ran(bench, "implied_state.json");
  const auto figure = [&](const char* metric) { return summary.at("metrics").at(metric).at("value").get<double>(); };
  const auto expected = by_hand();
  CHECK(std::abs(figure("walk/direct.x/at 1 s") - (0.2 - expected[1].value)) < 1e-12);
  CHECK(std::abs(figure("walk/direct.x/at 2 s") - (0.2 - expected[2].value)) < 1e-12);
  CHECK(std::abs(figure("walk/direct.x/final") - (0.3 - expected[4].value)) < 1e-12);
  CHECK(std::abs(figure("walk/direct.x/sigma at 2 s") - expected[2].sigma) < 1e-12);
  CHECK(std::abs(figure("walk/direct.x/sigma") - expected[4].sigma) < 1e-12);
  CHECK(std::abs(figure("walk/direct/nees at 2 s") - std::pow((0.2 - expected[2].value) / expected[2].sigma, 2)) <
        1e-9);
  // The filter itself goes on as if nobody had looked.
  bench.write(
      "plain.json",
      R"({"extends": "implied_state.json", "filters": {"walk": {"implied_states": null}}, "evaluate": {"metrics": null},
    "reference": [{"channel": "truth", "blocks": {"walk/place": ["x"]}}]})");
  CHECK(ran(bench, "plain.json").at("filters").at("walk").at("reference").at("place.x") ==
        summary.at("filters").at("walk").at("reference").at("place.x"));
}

TEST_CASE("of more rows than a block has components an implied state is their weighted mean") {
  const Workbench bench;
  bench.write("twice.json", R"({
    "extends": "good.json",
    "filters": { "walk": {
      "measurements": { "seen": { "fields": { "z0": "z0", "z1": "z0" }, "H": [[1], [2]], "sigma": [0.1, 0.4], "gate": null } },
      "implied_states": { "direct": { "measurement": "seen", "block": "place" } } } },
    "reference": [ { "channel": "truth", "blocks": { "walk/direct": ["x"] } } ],
    "evaluate": { "metrics": ["walk/direct.x/at 2 s", "walk/direct.x/sigma at 2 s"] },
    "covariance": { "duration": "4 s", "channels": { "fix": { "interval": "1 s" } }, "metrics": ["walk/direct/own sigma at 2 s"] }
  })");
  // z0 = x + v0, z1 = 2 x + v1: weights 1 / 0.1^2 and 2^2 / 0.4^2 of the values z and z / 2.
  const double weight = 1 / 0.01 + 4 / 0.16, value = fixes[2] * (1 / 0.01 + 0.5 * 4 / 0.16) / weight;
  const auto summary = ran(bench, "twice.json");
  const auto figure = [&](const char* metric) { return summary.at("metrics").at(metric).at("value").get<double>(); };
  CHECK(std::abs(figure("walk/direct.x/at 2 s") - (0.2 - value)) < 1e-12);
  CHECK(std::abs(figure("walk/direct.x/sigma at 2 s") - 1 / std::sqrt(weight)) < 1e-12);
  const auto outcome = binnacle::test::binnacle(bench, {"covariance", "twice.json", "--json"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto own = json::parse(outcome.out).at("variants").at("base").at("metrics").at("walk/direct/own sigma at 2 s");
  CHECK(std::abs(own.at("mean").get<double>() - 1 / std::sqrt(weight)) < 1e-12);
}

TEST_CASE("an implied state is recorded where there is one") {
  const Workbench bench;
  bench.write("implied_state.json", with_implied_state);
  ran(bench, "implied_state.json", {"--out", "out"});
  std::istringstream lines(read_file(bench.path("out/walk.csv")));
  std::string line;
  std::getline(lines, line);
  CHECK(line == "t[s],place.x[m],offset.x[m],place.x.sigma[m],offset.x.sigma[m],direct.x[m],direct.x.sigma[m]");
  const auto recorded = binnacle::results::read(bench.path("out")).run->filters.at(0).others;  // all digits
  REQUIRE(recorded.size() == 2);
  CHECK(recorded[0].name == "direct.x");
  CHECK(recorded[1].name == "direct.x.sigma");
  std::size_t row = 0;
  for (const auto& expected : by_hand()) {
    REQUIRE(std::getline(lines, line));
    double value = 0, sigma = 0;
    REQUIRE(std::sscanf(line.c_str(), "%*f,%*f,%*f,%*f,%*f,%lf,%lf", &value, &sigma) == 2);
    CHECK(is_as_stated("direct.x[m]", expected.value, value));
    CHECK(is_as_stated("direct.x.sigma[m]", expected.sigma, sigma));
    CHECK(std::abs(recorded[0].values.at(row) - expected.value) < 1e-12);
    CHECK(std::abs(recorded[1].values.at(row++) - expected.sigma) < 1e-12);
  }
  CHECK_FALSE(std::getline(lines, line));
}

TEST_CASE("a covariance analysis gives an implied state the sigma that the running filter does") {
  const Workbench bench;
  bench.write("implied_state.json", with_implied_state);
  const auto outcome = binnacle::test::binnacle(bench, {"covariance", "implied_state.json", "--json"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto figures = json::parse(outcome.out).at("variants").at("base").at("metrics");
  CHECK(std::abs(figures.at("walk/direct/sigma").at("mean").get<double>() - by_hand()[4].sigma) < 1e-12);
  CHECK(std::abs(figures.at("walk/direct/own sigma at 2 s").at("mean").get<double>() - by_hand()[2].sigma) < 1e-12);
}

TEST_CASE("an implied state of several components through a matrix") {
  const Workbench bench;
  bench.write("two.csv", "t,a,b\n0,2,8\n1,3,6\n");
  bench.write("two_truth.csv", "t,x,y\n1,1.2,1.6\n");
  bench.write("two.json", R"~({
    "binnacle": 1,
    "sources": {
      "seen": { "type": "csv", "path": "two.csv", "columns": { "z0": { "column": "a", "unit": "m" }, "z1": { "column": "b", "unit": "m" } } },
      "truth": { "type": "csv", "path": "two_truth.csv", "columns": { "x0": { "column": "x", "unit": "m" }, "x1": { "column": "y", "unit": "m" } } } },
    "filters": { "f": {
      "blocks": { "place": { "type": "vector", "size": 2, "unit": "m", "sigma": 1 } },
      "process": { "stays": { "type": "random_constant", "blocks": { "x": "place" } } },
      "measurements": { "see": { "type": "linear_measurement", "channel": "seen", "blocks": { "x": "place" },
                                 "H": [[2, 1], [0, 4]], "sigma": [0.2] } },
      "implied_states": { "direct": { "measurement": "see", "block": "place" } } } },
    "reference": [ { "channel": "truth", "blocks": { "f/direct": ["x0", "x1"] } } ],
    "evaluate": { "metrics": ["f/direct.x0/final", "f/direct.x1/final", "f/direct.x0/sigma", "f/direct.x1/sigma"] }
  })~");
  const auto summary = ran(bench, "two.json");
  const auto figure = [&](const char* metric) { return summary.at("metrics").at(metric).at("value").get<double>(); };
  // Nothing but the block is in the measurement: H⁻¹ z, with the noise of z alone, whatever the filter holds.
  CHECK(std::abs(figure("f/direct.x0/final") - (1.2 - (3 - 1.5) / 2)) < 1e-12);
  CHECK(std::abs(figure("f/direct.x1/final") - (1.6 - 1.5)) < 1e-12);
  CHECK(std::abs(figure("f/direct.x0/sigma") - 0.2 * std::sqrt(0.25 + 1 / 64.0)) < 1e-12);
  CHECK(std::abs(figure("f/direct.x1/sigma") - 0.05) < 1e-12);
}

TEST_CASE("what is wrong with an implied state is reported") {
  const Workbench bench;
  bench.write("implied_state.json", with_implied_state);
  const auto refused = [&](const std::string& implied_states, const std::string& code, const std::string& words) {
    bench.write("wrong.json", R"({"extends": "implied_state.json", "filters": {"walk": {"implied_states": )" +
                                  implied_states + "}}}");
    const auto outcome = binnacle::test::binnacle(bench, {"check", "wrong.json"});
    INFO(implied_states << "\n" << outcome.err);
    CHECK(outcome.status == 3);
    CHECK(outcome.err.find("[" + code + "]") != std::string::npos);
    CHECK(outcome.err.find(words) != std::string::npos);
  };
  refused(R"({"direct": {"measurement": "sean"}})", "B027", "did you mean 'seen'");
  refused(R"({"direct": {"block": "plaice"}})", "B015", "did you mean 'place'");
  refused(R"({"direct": {"blocks": "place"}})", "B012", "did you mean 'block'");
  refused(R"({"other": {"measurement": "seen"}})", "B010", "block");
  refused(R"({"place": {"measurement": "seen", "block": "place"}})", "B002", "called 'place' already");
  bench.write("unseen.json", R"({"extends": "implied_state.json", "filters": {"walk": {
    "blocks": {"idle": {"type": "vector", "size": 1, "unit": "m", "init": {"x": 0}, "sigma": 1}},
    "process": {"idles": {"type": "random_constant", "blocks": {"x": "idle"}}},
    "implied_states": {"direct": {"block": "idle"}}}}})");
  const auto outcome = binnacle::test::binnacle(bench, {"check", "unseen.json"});
  INFO(outcome.err);
  CHECK(outcome.status == 3);
  CHECK(outcome.err.find("measurement 'seen' does not determine block 'idle'") != std::string::npos);
}

}  // namespace implied_state_test
