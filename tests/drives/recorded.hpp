// SPDX-License-Identifier: Apache-2.0
// How a config is run on recorded drives.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "../recorded_data.hpp"
#include "catch.hpp"
#include "score/run.hpp"

namespace recorded {

inline std::optional<std::filesystem::path> data() { return binnacle::test::recorded_data("drives"); }

/// The summary of configs/CONFIG.json; what fails is reported with the config's name.
inline nlohmann::ordered_json run(const std::filesystem::path& folder, const std::string& config,
                                  std::vector<std::string> sets = {},
                                  binnacle::score::RunObserver* observer = nullptr) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  binnacle::LoadOptions load;
  load.vars["drives"] = folder.string();
  load.sets = std::move(sets);
  binnacle::score::RunOptions options;
  options.observer = observer;
  const auto composition = binnacle::score::load(BINNACLE_TEST_PROJECT "/configs/" + config + ".json", load);
  const binnacle::score::RunResult result = binnacle::score::run(composition, options);
  INFO(config << "\n" << result.failures.text());
  CHECK(result.failures.empty());
  if (!result.warnings.empty()) std::printf("%s: %s\n", config.c_str(), result.warnings.text().c_str());
  return result.summary;
}

}  // namespace recorded
