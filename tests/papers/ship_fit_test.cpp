// SPDX-License-Identifier: Apache-2.0
// Paper 004 with motions that are fitted: to a record (the model against it, filter A against its own covariance) and to a sea;
// and of order 4.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "../recorded_data.hpp"
#include "catch.hpp"
#include "study_of.hpp"

namespace ship_fit_test {

namespace {

using nlohmann::ordered_json;

/// What the command prints as JSON.
ordered_json printed(const std::string& arguments) {
  const auto file = std::filesystem::temp_directory_path() / ("binnacle_fit_" + std::to_string(::getpid()) + ".json");
  const std::string command =
      std::string("'") + BINNACLE_TEST_COMMAND + "' " + arguments + " > '" + file.string() + "' 2> /dev/null";
  INFO(command);
  REQUIRE(std::system(command.c_str()) == 0);
  std::ifstream in(file);
  auto json = ordered_json::parse(in);
  std::filesystem::remove(file);
  return json;
}

double found(const ordered_json& explained, const std::string& at, const std::string& name) {
  INFO(at << ", " << name);
  for (const auto& component : explained.at("found"))
    if (component.at("at") == at)
      for (const auto& figure : component.at("figures"))
        if (figure.at("name") == name) return figure.at("value").get<double>();
  FAIL("not found");
  return 0;
}

/// Twice the standard deviation of a column of degrees [rad].
double significant_amplitude(const std::filesystem::path& file, std::size_t column) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  double sum = 0, squares = 0;
  int n = 0;
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    std::string cell;
    for (std::size_t i = 0; i <= column; ++i) std::getline(cells, cell, ',');
    const double x = std::stod(cell) * std::atan(1.0) / 45;
    sum += x, squares += x * x, ++n;
  }
  REQUIRE(n == 714);
  return 2 * std::sqrt(squares / n - sum * sum / n / n);
}

}  // namespace

TEST_CASE("paper 004 on a recorded motion: the fitted spectrum is the record's") {
  const auto folder = binnacle::test::recorded_data("ship");
  if (!folder) return;
  for (const std::string variant : {"order 2", "order 4"}) {
    const auto explained = printed(std::string("explain '") + BINNACLE_TEST_PROJECT +
                                   "/configs/ship_motion/recorded.json' --json --var ship='" + folder->string() +
                                   "' --variant '" + variant + "'");
    for (const auto& [process, column] : {std::pair<std::string, std::size_t>{"rolling", 1}, {"pitching", 2}}) {
      const std::string at = "/filters/ship/process/" + process;
      INFO(variant << ", " << process);
      const double recorded = significant_amplitude(*folder / "nbp1406_motion.csv", column);
      CHECK(std::abs(found(explained, at, "significant amplitude, given") / recorded - 1) < 1e-6);
      CHECK(std::abs(found(explained, at, "significant amplitude, fitted") / recorded - 1) < 0.15);
      CHECK(std::abs(2 * found(explained, at, "sigma") / recorded - 1) < 0.15);
      CHECK(std::abs(found(explained, at, "peak, fitted") - found(explained, at, "peak, given")) <=
            found(explained, at, "resolution"));
    }
  }
}

TEST_CASE("paper 004 in a sea: a poor fit is a warning and no error") {
  const std::string config = std::string("'") + BINNACLE_TEST_PROJECT + "/configs/ship_motion/sea.json'";
  const auto warnings = printed("check --json " + config);
  REQUIRE_FALSE(warnings.empty());
  for (const auto& warning : warnings) CHECK(warning.at("code") == "B032");
  const auto summary = papers::summary_of("covariance", "ship_motion/sea.json", "");
  for (const std::string speed : {"4 m/s", "8 m/s"}) {
    INFO(speed);
    const auto sigma = [&](const char* order) {
      return papers::over_runs(summary, speed + " order " + order, "ship/pitch/sigma", "rms");
    };
    CHECK(sigma("4") < sigma("2"));
    CHECK(sigma("2") < 0.6);
  }
}

TEST_CASE("paper 004 on a recorded motion: filter A errs as much as its covariance says") {
  const auto folder = binnacle::test::recorded_data("ship");
  if (!folder) return;
  const auto summary =
      papers::summary_of("study", "ship_motion/recorded.json", "--runs 60 --var ship='" + folder->string() + "'");
  for (const std::string variant : {"order 2", "order 4", "order 2, halves", "order 4, halves"})
    for (const std::string axis : {"roll", "pitch"}) {
      const double drawn = papers::over_runs(summary, variant, "ship/" + axis + ".angle/rms", "rms");
      const double computed = papers::over_runs(summary, variant, "ship/" + axis + ".angle/sigma", "rms");
      INFO(variant << ", " << axis << ": " << drawn << ", the covariance says " << computed);
      CHECK(std::abs(drawn / computed - 1) < 0.15);
    }
}

TEST_CASE("paper 004 of order 4: the covariance analysis agrees with 2000 drawn runs") {
  const auto drawn = papers::summary_of("study", "ship_motion/fourth_order.json", "--runs 2000");
  const auto computed = papers::summary_of("covariance", "ship_motion/fourth_order.json", "");
  const double rms = papers::over_runs(drawn, "matched", "ship/pitch.angle/final", "rms");
  const double se = papers::over_runs(drawn, "matched", "ship/pitch.angle/final", "se_rms");
  const double expected = papers::over_runs(computed, "matched", "ship/pitch.angle/sigma", "rms");
  INFO(rms << " +- " << se << ", computed " << expected);
  CHECK(std::abs(rms - expected) < 3 * se);
  const double nees = papers::over_runs(drawn, "matched", "ship/pitch/nees", "mean");
  CHECK(std::abs(nees - 1) < 0.083);  // 99 % of such means of 2000
}

}  // namespace ship_fit_test
