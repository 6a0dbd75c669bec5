// SPDX-License-Identifier: Apache-2.0
// The configs of configs/gallery, and what a run of one ends with.
#pragma once

#include "catch.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace binnacle::test {

inline const std::filesystem::path gallery = std::filesystem::path(BINNACLE_TEST_PROJECT) / "configs/gallery";

/// Their names, without ".json".
inline std::vector<std::string> examples() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(gallery))
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// The only filter of the run's summary.
inline nlohmann::json summary_of(const Workbench& bench, const std::string& config) {
  const auto outcome = binnacle(bench, {"run", config, "--json"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto filters = nlohmann::json::parse(outcome.out).at("filters");
  REQUIRE(filters.size() == 1);
  return filters.begin().value();
}

inline bool begins(const std::string& text, const std::string& with) { return text.rfind(with, 0) == 0; }

}  // namespace binnacle::test
