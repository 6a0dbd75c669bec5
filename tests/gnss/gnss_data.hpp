// SPDX-License-Identifier: Apache-2.0
// Recorded GNSS data: where they are, and their tables. Looked for in $BINNACLE_DATA, else beside the project in
// ../shared/data; without any, tests say so and pass.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace binnacle::test {

inline std::optional<std::filesystem::path> gnss_data() {
  namespace fs = std::filesystem;
  const char* told = std::getenv("BINNACLE_DATA");
  const fs::path root = told ? fs::path(told) : fs::path(BINNACLE_TEST_PROJECT) / ".." / "shared" / "data";
  const fs::path folder = fs::weakly_canonical(root / "gnss");
  if (fs::is_directory(folder)) return folder;
  std::printf("SKIPPED: no data (%s is not there; BINNACLE_DATA names another folder)\n", folder.c_str());
  return std::nullopt;
}

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
