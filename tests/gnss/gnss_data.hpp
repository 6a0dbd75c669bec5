// SPDX-License-Identifier: Apache-2.0
// Recorded GNSS data, and their tables.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "../recorded_data.hpp"

namespace binnacle::test {

inline std::optional<std::filesystem::path> gnss_data() { return recorded_data("gnss"); }

/// The rows of a table with a header, each as column → text.
inline std::vector<std::map<std::string, std::string>> table(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::vector<std::string> names;
  std::vector<std::map<std::string, std::string>> rows;
  for (std::string line; std::getline(in, line);) {
    std::istringstream text(line);
    std::vector<std::string> cells;
    for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
    if (names.empty()) {
      names = cells;
      continue;
    }
    auto& row = rows.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i) row[names.at(i)] = cells[i];
  }
  return rows;
}

}  // namespace binnacle::test
