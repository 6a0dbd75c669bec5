// SPDX-License-Identifier: Apache-2.0
// A CSV of numbers: its header's names, and its columns.
#pragma once

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "command.hpp"

namespace binnacle::test {

struct Csv {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
};

inline Csv read_csv(const std::filesystem::path& path) {
  Csv csv;
  std::istringstream lines(read_file(path));
  std::string line, cell;
  std::getline(lines, line);
  std::istringstream header(line);
  while (std::getline(header, cell, ',')) csv.names.push_back(cell);
  csv.columns.resize(csv.names.size());
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (auto& column : csv.columns) {
      std::getline(cells, cell, ',');
      column.push_back(std::stod(cell));
    }
  }
  return csv;
}

}  // namespace binnacle::test
