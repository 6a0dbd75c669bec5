// SPDX-License-Identifier: Apache-2.0
// The summaries of `binnacle study` and `binnacle run` on the configs of a paper.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "catch.hpp"

namespace papers {

/// verb: "study" or "run"; config: below configs/.
inline nlohmann::ordered_json summary_of(const std::string& verb, const std::string& config,
                                         const std::string& options) {
  const auto file = std::filesystem::temp_directory_path() / ("binnacle_paper_" + std::to_string(::getpid()) + ".json");
  const std::string command = std::string("'") + BINNACLE_TEST_COMMAND + "' " + verb + " '" + BINNACLE_TEST_PROJECT +
                              "/configs/" + config + "' " + options + " --summary '" + file.string() + "' > /dev/null";
  INFO(command);
  REQUIRE(std::system(command.c_str()) == 0);
  std::ifstream in(file);
  auto summary = nlohmann::ordered_json::parse(in);
  std::filesystem::remove(file);
  return summary;
}

/// A statistic over the runs of a variant's metric.
inline double over_runs(const nlohmann::ordered_json& summary, const std::string& variant, const std::string& metric,
                        const char* statistic) {
  INFO(variant << ", " << metric);
  const auto& entry = summary.at("variants").at(variant);
  REQUIRE(entry.at("failed") == 0);
  return entry.at("metrics").at(metric).at(statistic).get<double>();
}

}  // namespace papers
