// SPDX-License-Identifier: Apache-2.0
// binnacle observe on a recorded drive.
#include "catch.hpp"

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "recorded_data.hpp"

namespace recorded_test {

using namespace binnacle::test;
using nlohmann::json;

TEST_CASE("observe: a recorded drive, at rest and under way") {
  const auto data = recorded_data("drives");
  if (!data) return;
  const Workbench bench;
  const auto outcome =
      binnacle::test::binnacle(bench, {"observe", BINNACLE_TEST_PROJECT "/configs/drives/medium-turn-loop.json",
                                       "--var", "drives=" + data->string(), "--json", "--quiet", "--window",
                                       "start:start+5", "--window", "start:start+60"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const json windows = json::parse(outcome.out).at("filters").at("ins");
  REQUIRE(windows.size() == 2);
  for (const auto& window : windows) {
    REQUIRE(window.contains("inconsistent"));
    CHECK(window.at("inconsistent").empty());
    double singular = 1e9;
    for (const double value : window.at("singular_values")) {
      CHECK(value <= singular);
      singular = value;
    }
  }
  const auto removed = [&](int window, const char* component) {
    return windows[static_cast<std::size_t>(window)].at("components").at(component).at("removed").get<double>();
  };
  // More data show more, of every component.
  for (const auto& [name, component] : windows[0].at("components").items())
    CHECK(removed(1, name.c_str()) >= removed(0, name.c_str()));
  CHECK(removed(1, "attitude.down") > 0.9);
  CHECK(removed(1, "gyro_bias.z") < 0.9);
}

}  // namespace recorded_test
