// SPDX-License-Identifier: Apache-2.0
// Paper 004: both tables by `binnacle covariance`, and that it agrees with drawn runs.
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "catch.hpp"

namespace ship_motion_test {

namespace {

using nlohmann::ordered_json;

ordered_json summary_of(const std::string& verb, const std::string& config) {
  const auto file = std::filesystem::temp_directory_path() / ("binnacle_ship_" + std::to_string(::getpid()) + ".json");
  const std::string command = std::string("'") + BINNACLE_TEST_COMMAND + "' " + verb + " '" + BINNACLE_TEST_PROJECT +
                              "/configs/ship_motion/" + config + "' --summary '" + file.string() + "' > /dev/null";
  INFO(command);
  REQUIRE(std::system(command.c_str()) == 0);
  std::ifstream in(file);
  auto summary = ordered_json::parse(in);
  std::filesystem::remove(file);
  return summary;
}

ordered_json analysed(const std::string& config) { return summary_of("covariance", config); }

double figure(const ordered_json& summary, const std::string& variant, const std::string& metric) {
  return summary.at("variants").at(variant).at("metrics").at(metric).at("rms").get<double>();
}

void check_near(double value, double paper, double part) {
  INFO(value << ", paper " << paper);
  CHECK(std::abs(value - paper) < part * paper);
}

}  // namespace

TEST_CASE("paper 004, table 1: without estimator, filters A, B and C over time") {
  const auto summary = analysed("table1.json");
  const auto at = [&](const char* variant, int t) {
    return figure(summary, variant, "ship/pitch/sigma at " + std::to_string(t) + " s");
  };
  const double none[] = {15.9806, 30.4917, 43.9232, 56.3421}, c[] = {12.9752, 23.7338, 33.4802, 42.4575};
  for (int k = 0; k < 4; ++k) {
    const int t = 1000 * (k + 1);
    check_near(at("none", t), none[k], 0.005);
    check_near(at("c", t), c[k], 0.005);
    check_near(at("a", t), 0.4281, 0.003);
    check_near(at("b", t), 0.5178, 0.003);
    CHECK(std::abs(at("a", t) / at("a", 4000) - 1) < 1e-3);
    CHECK(std::abs(at("b", t) / at("b", 4000) - 1) < 1e-3);
  }
  // What grows does not settle.
  const auto settled = [&](const char* variant) {
    return summary.at("variants").at(variant).at("metrics").at("ship/pitch/settled").at("mean");
  };
  CHECK(settled("none").is_null());
  CHECK(settled("c").is_null());
  CHECK(settled("a").get<double>() < 350);
  CHECK(settled("b").get<double>() < 350);
}

TEST_CASE("paper 004, table 2: other sensors and a filter with other beliefs") {
  const auto summary = analysed("table2.json");
  const auto sigma = [&](const std::string& variant) { return figure(summary, variant, "ship/pitch/sigma"); };
  struct Row {
    const char* name;
    double a, b, part;
  };
  for (const Row& row :
       {Row{"ga", 0.4281, 0.5178, 0.003}, Row{"na", 0.5099, 0.5183, 0.003}, Row{"da", 0.7738, 0.5188, 0.003},
        Row{"ra", 0.3341, 0.5148, 0.003}, Row{"ma", 0.4032, 0.5177, 0.003}, Row{"ba", 0.0781, 0.0785, 0.005}}) {
    INFO(row.name);
    check_near(sigma(row.name + std::string(" a")), row.a, row.part);
    check_near(sigma(row.name + std::string(" b")), row.b, row.part);
  }
  // B suffers less from a wrong model than A, and at the worst is better.
  CHECK(sigma("da a") / sigma("ga a") > 1.5);
  CHECK(sigma("da b") / sigma("ga b") < 1.01);
  CHECK(sigma("da b") < sigma("da a"));
  CHECK(sigma("ba a") < sigma("ra a"));
  CHECK(sigma("ra a") < sigma("ma a"));
  CHECK(sigma("ma a") < sigma("ga a"));
  CHECK(sigma("ra independent a") < sigma("ra a"));
  CHECK(sigma("ra independent b") > sigma("ra b"));
  const auto rate = [&](const std::string& variant) { return figure(summary, variant, "ship/pitch_rate/sigma"); };
  CHECK(rate("ma a") < 0.5 * rate("ra a"));
  CHECK(rate("ma a") < 0.5 * rate("ra independent a"));
  // What a mis-modelled filter believes is far too good.
  CHECK(figure(summary, "da a", "ship/pitch/own sigma") < 0.2);
}

TEST_CASE("paper 004: the covariance analysis agrees with 8000 drawn runs, with a right and a wrong model") {
  const auto drawn = summary_of("study", "monte_carlo.json"), computed = analysed("monte_carlo.json");
  for (const std::string variant : {"matched", "mismatched"})
    for (const auto& [error, sigma] : {std::pair<std::string, std::string>{"pitch.angle/final", "pitch.angle/sigma"},
                                       {"pitch.angle/at 5 s", "pitch.angle/sigma at 5 s"},
                                       {"reading.angle/final", "reading.angle/sigma"},
                                       {"reading.angle/at 5 s", "reading.angle/sigma at 5 s"}}) {
      const auto& figures = drawn.at("variants").at(variant).at("metrics").at("ship/" + error);
      REQUIRE(figures.at("n") == 8000);
      const double rms = figures.at("rms").get<double>(), se = figures.at("se_rms").get<double>();
      const double expected = figure(computed, variant, "ship/" + sigma);
      INFO(variant << ", " << error << ": " << rms << " +- " << se << ", computed " << expected);
      CHECK(std::abs(rms - expected) < 3 * se);
      CHECK(se < 0.01 * rms);
    }
  // What the running filter says of itself, and of filter B's output.
  for (const std::string subject : {"pitch.angle", "reading.angle"})
    for (const std::string variant : {"matched", "mismatched"})
      CHECK(std::abs(figure(drawn, variant, "ship/" + subject + "/sigma") /
                         figure(computed, variant, "ship/" + subject + "/own sigma") -
                     1) < 1e-9);
}

}  // namespace ship_motion_test
