// SPDX-License-Identifier: Apache-2.0
// configs/kitti on the two recorded drives: the segment errors that must be reached, and settings found on the other drive.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "catch.hpp"
#include "recorded.hpp"

namespace kitti_drives_test {

using namespace binnacle;
using nlohmann::ordered_json;

namespace {

double translation(const std::filesystem::path& folder, const std::string& config) {
  const auto data = folder.string();
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions load;
  load.vars["kitti"] = data;
  const auto composition = score::load(BINNACLE_TEST_PROJECT "/configs/kitti/" + config, load);
  const score::RunResult result = score::run(composition, {});
  INFO(config << "\n" << result.failures.text());
  CHECK(result.failures.empty());
  const auto& metrics = result.summary.at("metrics");
  const auto value = [&](const char* statistic) {
    return metrics.at(std::string("ins/position.segments/") + statistic).at("value").get<double>();
  };
  std::printf("%-28s %6.3f %%  %8.5f deg/m\n", config.c_str(), value("translation"), value("rotation"));
  return value("translation");
}

}  // namespace

TEST_CASE("two drives of KITTI by dead reckoning, one setting for both") {
  const auto folder = binnacle::test::recorded_data("kitti");
  if (!folder) return;
  CHECK(translation(*folder, "dead-reckoning.json") <= 1.25);
  CHECK(translation(*folder, "drive-09.json") <= 1.5);
}

TEST_CASE("KITTI's inertial data are late against its attitude") {
  const auto folder = binnacle::test::recorded_data("kitti");
  if (!folder) return;
  // Half of the error of drive 07 is their stamps'.
  CHECK(translation(*folder, "stamps.json") < 0.6 * translation(*folder, "dead-reckoning.json"));
}

TEST_CASE(
    "springs and tyres that are estimated reduce the error of KITTI's drives, also of two that no setting has seen") {
  const auto folder = binnacle::test::recorded_data("kitti");
  if (!folder) return;
  CHECK(translation(*folder, "compliance.json") < translation(*folder, "stamps.json"));
  CHECK(translation(*folder, "compliance-09.json") < 0.7);
  // A published filter with fixed covariances: 1.98 and 1.69 %.
  CHECK(translation(*folder, "compliance-01.json") <= 1.98);
  CHECK(translation(*folder, "compliance-06.json") <= 1.69);
}

TEST_CASE("the config of KITTI has no more than 25 lines") {
  std::ifstream file(BINNACLE_TEST_PROJECT "/configs/kitti/dead-reckoning.json");
  int lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  CHECK((lines > 10 && lines <= 25));
}

}  // namespace kitti_drives_test
