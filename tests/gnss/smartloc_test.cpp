// SPDX-License-Identifier: Apache-2.0
// The configs of configs/smartloc on recorded pseudoranges of a street canyon: figures that must be reached.
#include <filesystem>
#include <string>

#include "../recorded_data.hpp"
#include "catch.hpp"
#include "score/run.hpp"

using namespace binnacle;
using nlohmann::ordered_json;

namespace {

ordered_json horizontal(const std::filesystem::path& data, const std::string& config) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions load;
  load.vars["smartloc"] = data.string();
  const auto result = score::run(score::load(BINNACLE_TEST_PROJECT "/configs/smartloc/" + config + ".json", load));
  INFO(config << "\n" << result.failures.text());
  CHECK(result.failures.empty());
  const auto& filter = result.summary.at("filters").at("car");
  // No epoch is dropped.
  CHECK(filter.at("measurements").at("ranges").at("accepted") == 1372);
  return filter.at("reference").at("position.horizontal");
}

}  // namespace

TEST_CASE("smartLoc: a car in a street canyon, without odometry and with it", "[data]") {
  const auto data = binnacle::test::recorded_data("smartloc");
  if (!data) return;
  const auto alone = horizontal(*data, "alone"), odometry = horizontal(*data, "odometry");
  CHECK(alone.at("n") == 1372);
  CHECK(odometry.at("n") == 1372);
  CHECK(alone.at("rms").get<double>() <= 27.0);
  CHECK(odometry.at("rms").get<double>() <= 28.0);
  CHECK(odometry.at("rms").get<double>() < alone.at("rms").get<double>());
}
