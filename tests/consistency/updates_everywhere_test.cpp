// SPDX-License-Identifier: Apache-2.0
// Every way to update runs on configs of each subject: nothing breaks, nothing is not a number, and the verdict is reported.
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "binnacle/session.hpp"
#include "catch.hpp"
#include "run/runtime.hpp"
#include "score/run.hpp"

namespace updates_everywhere_test {

using namespace binnacle;

namespace {

LoadOptions with_update(const std::string& file, const std::string& update) {
  LoadOptions options;
  const auto composition = score::load(file, options);
  for (const auto& filter : composition->filters())
    for (const auto& measurement : filter.measurements)
      options.sets.push_back("/filters/" + filter.name + "/measurements/" + measurement.name + "/update=" + update);
  return options;
}

}  // namespace

TEST_CASE("configs of each subject run with every way to update") {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  // One of the variants that it has.
  const std::string configs = BINNACLE_TEST_PROJECT "/configs/";
  const auto tight = std::filesystem::temp_directory_path() / ("updates_" + std::to_string(::getpid()) + ".json");
  std::ofstream(tight) << R"({"extends": [")" + configs + R"(ins_gps/turns.json", ")" + configs +
                              R"(ins_gps/parts.json#/tc", ")" + configs + R"(ins_gps/parts.json#/low"]})";
  for (const std::string& file :
       {configs + "quickstart.json", configs + "updates/bearing.json", configs + "transfer_alignment/base.json",
        configs + "ship_motion/monte_carlo.json", configs + "land/matched.json", tight.string()})
    for (const std::string update : {R"("ekf")", R"("iterated")", R"("unscented")"}) {
      CAPTURE(file, update);
      const auto composition = score::load(file, with_update(file, update));
      const auto summary = score::run(composition, {1, 0}).summary;
      for (const auto& filter : composition->filters()) {
        const auto& figures = summary["filters"][filter.name];
        const auto verdict = figures["verdict"]["state"].get<std::string>();
        double accepted = 0, linearizations = 0, not_converged = 0, instead = 0;
        for (const auto& measurement : figures["measurements"]) {
          accepted += measurement["accepted"].get<double>();
          if (measurement.contains("linearized_instead")) instead += measurement["linearized_instead"].get<double>();
          if (!measurement.contains("iterated")) continue;
          linearizations += measurement["iterated"]["linearizations"].get<double>();
          not_converged += measurement["iterated"]["not_converged"].get<double>();
        }
        std::printf("%-18s %-6s %-12s %s, %.0f accepted", std::filesystem::path(file).parent_path().filename().c_str(),
                    filter.name.c_str(), update.c_str(), verdict.c_str(), accepted);
        if (linearizations > 0)
          std::printf(", %.2f linearizations, %.0f not converged", linearizations / accepted, not_converged);
        if (instead > 0) std::printf(", %.0f linearized instead", instead);
        std::printf("\n");
        CHECK(accepted > 0);
        for (const auto& reason : figures["verdict"]["reasons"]) CHECK(reason["code"] != "B080");
        for (const auto& [name, entry] : figures["consistency"].items()) {
          CAPTURE(filter.name, name);
          CHECK(std::isfinite(entry["nees_mean"].get<double>()));
        }
      }
    }
  std::filesystem::remove(tight);
}

}  // namespace updates_everywhere_test
