// SPDX-License-Identifier: Apache-2.0
// allan: a simulated sensor's own figures come back; what is wrong with a record is reported.
#include "catch.hpp"

#include <cmath>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace allan_test {

using namespace binnacle::test;

namespace {

Outcome allan(const Workbench& bench, const std::string& config, std::vector<std::string> options) {
  options.insert(options.begin(), {"allan", config});
  return binnacle::test::binnacle(bench, options);
}

nlohmann::json term(const nlohmann::json& field, const std::string& name) {
  for (const auto& term : field.at("terms"))
    if (term.at("term") == name) return term;
  return nullptr;
}

}  // namespace

TEST_CASE("allan finds the noise that the quickstart's sensors are simulated with") {
  const Workbench bench;
  const auto outcome = allan(bench, BINNACLE_TEST_PROJECT "/configs/quickstart.json",
                             {"--channel", "drive.imu", "--json", "--picture", "imu.svg", "--set",
                              R"(/sources/drive/segments=[{"do": "still", "duration": "1000 s"}])"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto json = nlohmann::json::parse(outcome.out);
  CHECK(json.at("samples") == 100'000);
  const double gyro = 0.3 * std::acos(-1.0) / 180 / 60, accelerometer = 0.05 / 60;
  for (const char* name : {"wx", "wy", "wz", "fx", "fy", "fz"}) {
    INFO(name);
    const auto& field = json.at("fields").at(name);
    const bool is_gyro = name[0] == 'w';
    CHECK(field.at("unit") == (is_gyro ? "rad/s" : "m/s^2"));
    const auto white = term(field, "white");
    REQUIRE_FALSE(white.is_null());
    CHECK(white.at("unit") == (is_gyro ? "rad/sqrt(s)" : "m/s/sqrt(s)"));
    CHECK(std::abs(white.at("value").get<double>() / (is_gyro ? gyro : accelerometer) - 1) < 0.02);
    CHECK(white.at("parameters").contains(is_gyro ? "phi_error.gyro_noise" : "phi_error.accel_noise"));
    CHECK(field.at("chi_square") < 3);
  }
  CHECK(read_file(bench.path("imu.svg")).starts_with("<svg "));
}

TEST_CASE("allan reports gaps and a channel that is not there") {
  const Workbench bench;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::ofstream file(bench.path("rate.csv"));
  for (int k = 0; k < 4000; ++k) {
    if (k == 1500) k = 1600;  // a gap of one second
    file << 0.01 * k << ',' << normal(random) << '\n';
  }
  file.close();
  bench.write("rate.json", R"({"binnacle": 1, "sources": {"rate": {"type": "csv", "path": "rate.csv", "header": false,
    "time": {"column": "1"}, "max_gap": "10 s", "columns": {"w": {"column": "2", "unit": "rad/s", "kind": "rate"}}}}, "filters": {}})");
  const auto outcome = allan(bench, "rate.json", {"--channel", "rate"});
  INFO(outcome.err << outcome.out);
  REQUIRE(outcome.status == 0);
  CHECK(outcome.out.find("1 gap of together 1.000 s") != std::string::npos);
  CHECK(outcome.out.find("white") != std::string::npos);
  const auto wrong = allan(bench, "rate.json", {"--channel", "rates"});
  CHECK(wrong.status == 2);
  CHECK(wrong.err.find("did you mean 'rate'?") != std::string::npos);
}

}  // namespace allan_test
