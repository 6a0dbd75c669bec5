// SPDX-License-Identifier: Apache-2.0
// A CSV of numbers: its header's names, and its columns.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
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

/// Half a unit of the last digit that results.md states for a number of FILTER.csv under this header; 0: all digits there are.
inline double stated_error(const std::string& header, double value) {
  const std::string name = header.substr(0, header.find('[')), unit = header.substr(name.size());
  const auto significant = [&](int digits) {
    return value == 0 ? 0 : 0.5 * std::pow(10, std::floor(std::log10(std::abs(value))) - digits + 1);
  };
  if (name.ends_with(".sigma") || name.ends_with(".noise")) return significant(5);
  const std::map<std::string, double> units{{"[rad]", 1e-11},  {"[m]", 1e-4}, {"[m/s]", 1e-6}, {"[rad/s]", 1e-9},
                                            {"[m/s^2]", 1e-7}, {"[1]", 1e-9}, {"[s]", 1e-12}};
  const auto found = units.find(unit);
  return found == units.end() ? 0 : std::min(0.5 * found->second, significant(6));
}

/// Whether what the CSV has is the exact number, rounded as stated; a bit of the rounding to a double is let pass.
inline bool is_as_stated(const std::string& header, double exact, double read) {
  if (std::isnan(exact)) return std::isnan(read);
  return std::abs(read - exact) <= stated_error(header, exact) * (1 + 1e-4) + 1e-16 * std::abs(exact);
}

}  // namespace binnacle::test
