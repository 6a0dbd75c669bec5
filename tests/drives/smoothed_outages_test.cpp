// SPDX-License-Identifier: Apache-2.0
// Smoothed, the twenty outages of the recorded drives are bridged from both sides.
#include <cstdio>
#include <string>
#include <vector>

#include "catch.hpp"
#include "recorded.hpp"

namespace smoothed_outages_test {

using nlohmann::ordered_json;

namespace {

const std::vector<std::string> drives = {"long_drive", "parkinglot", "medium_turn_loop", "mixed_turns", "stop_go"};

struct Means {
  double forward, smoothed;
};

/// The largest horizontal error inside of each outage, against its withheld fixes: the mean of twenty.
Means means_of_largest(const std::string& config, std::vector<std::string> sets = {}) {
  for (const std::string& drive : drives) sets.push_back("/filters/" + drive + "/smoother=fixed_interval");
  const ordered_json summary = recorded::run(*recorded::data(), config, std::move(sets));
  const auto mean = [&](const std::string& suffix) {
    double sum = 0;
    int count = 0;
    for (const std::string& drive : drives)
      for (const auto& [window, figures] : summary.at("filters").at(drive + suffix).at("windows").items()) {
        sum += figures.at("position.horizontal").at("max").get<double>();
        ++count;
      }
    REQUIRE(count == 20);
    return sum / count;
  };
  return {mean(""), mean(".smoothed")};
}

}  // namespace

TEST_CASE("smoothed outages: the largest error, inertial alone and with the non-holonomic constraint") {
  if (!recorded::data()) return;
  const Means inertial = means_of_largest("drives/outages");
  std::vector<std::string> no_zupt;
  for (const std::string& drive : drives)
    no_zupt.insert(no_zupt.end(),
                   {"/filters/" + drive + "/measurements/zupt=null", "/filters/" + drive + "/trust=null"});
  const Means constrained = means_of_largest("land/outages", no_zupt);
  const Means wheels = means_of_largest("land/outages");
  std::printf("mean of the largest horizontal error in 20 outages, forward and smoothed (at most)\n");
  std::printf("  inertial alone                 %.2f m, %.3f m (0.60)\n", inertial.forward, inertial.smoothed);
  std::printf("  non-holonomic constraint       %.2f m, %.3f m (0.75)\n", constrained.forward, constrained.smoothed);
  std::printf("  and zero-velocity updates      %.2f m, %.3f m (0.75)\n", wheels.forward, wheels.smoothed);
  CHECK(inertial.smoothed <= 0.60);
  CHECK(constrained.smoothed <= 0.75);
  CHECK(wheels.smoothed <= 0.75);
}

}  // namespace smoothed_outages_test
