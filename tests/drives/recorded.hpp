// SPDX-License-Identifier: Apache-2.0
// Where recorded drives lie, and how a config is run on them. Data are looked for in $BINNACLE_DATA, else beside the
// project in ../shared/data; without any, tests say so and pass.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/run.hpp"
#include "catch.hpp"

namespace recorded {

inline std::optional<std::filesystem::path> data() {
  namespace fs = std::filesystem;
  const char* told = std::getenv("BINNACLE_DATA");
  const fs::path root = told ? fs::path(told) : fs::path(BINNACLE_TEST_PROJECT) / ".." / "shared" / "data";
  const fs::path folder = fs::weakly_canonical(root / "drives");
  if (fs::is_directory(folder)) return folder;
  std::printf("SKIPPED: no data (%s is not there; BINNACLE_DATA names another folder)\n", folder.c_str());
  return std::nullopt;
}

/// The summary of configs/CONFIG.json; what fails is told with the config's name.
inline nlohmann::ordered_json run(const std::filesystem::path& folder, const std::string& config,
                                  std::vector<std::string> sets = {}, binnacle::RunObserver* observer = nullptr) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  binnacle::LoadOptions load;
  load.vars["drives"] = folder.string();
  load.sets = std::move(sets);
  binnacle::RunOptions options;
  options.observer = observer;
  const auto composition = binnacle::Composition::load(BINNACLE_TEST_PROJECT "/configs/" + config + ".json", load);
  const binnacle::RunResult result = binnacle::run(composition, options);
  INFO(config << "\n" << result.failures.text());
  CHECK(result.failures.empty());
  if (!result.warnings.empty()) std::printf("%s: %s\n", config.c_str(), result.warnings.text().c_str());
  return result.summary;
}

}  // namespace recorded
