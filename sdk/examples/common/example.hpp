// SPDX-License-Identifier: Apache-2.0
// What the tests of the examples need: the models that the config is composed of, and the figures of a study.
#pragma once

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

#include <binnacle/parts.hpp>
#include <binnacle/testing.hpp>

namespace example {

/// As CMakeLists.txt sets it: CONFIG, PLUGIN (the library that is tested), COMMAND (binnacle).
inline std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  if (!value) throw std::runtime_error(std::string(name) + " is not set: run the tests with ctest");
  return value;
}

/// The config with this build's plugin; `sets` as those of `binnacle run --set`.
inline std::shared_ptr<const binnacle::Composition> compose(std::vector<std::string> sets = {}) {
  binnacle::LoadOptions options;
  options.sets.push_back("/plugins/0=" + environment("PLUGIN"));
  options.sets.insert(options.sets.end(), sets.begin(), sets.end());
  return binnacle::Composition::load(environment("CONFIG"), options);
}

/// The config as it is. What is taken out of it, a model's spec for one, lives as long as it.
inline const binnacle::Composition& composition() {
  static const std::shared_ptr<const binnacle::Composition> composed = compose();
  return *composed;
}

/// The ports of a bound model with these values, in the order of its spec; no value: the port is open. sigma: a plausible
/// error of each component, which differences are taken in steps of.
inline binnacle::testing::PortStates at(const std::vector<binnacle::parts::Value>& ports,
                                        const std::vector<std::vector<double>>& x, double sigma) {
  binnacle::testing::PortStates states(ports.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!x[i].empty()) states[i] = {ports.at(i).block.get(), x[i], sigma};
  return states;
}

/// |value − wanted| ≤ relative · |wanted| + absolute.
inline bool is_near(double value, double wanted, double relative, double absolute = 0) {
  return std::abs(value - wanted) <= relative * std::abs(wanted) + absolute;
}

/// By metric: its mean over the runs, and how many there were.
struct Figure {
  double mean = 0;
  int runs = 0;
};

/// `binnacle study` of the config with its own number of runs.
inline std::map<std::string, Figure> study() {
  const auto folder = std::filesystem::temp_directory_path() / ("example." + std::to_string(getpid()));
  const std::string command = "'" + environment("COMMAND") + "' study '" + environment("CONFIG") +
                              "' --set '/plugins/0=" + environment("PLUGIN") + "' --quiet --out '" + folder.string() +
                              "'";
  const int status = std::system(command.c_str());
  std::map<std::string, Figure> figures;
  std::ifstream csv(folder / "study.csv");
  std::string line;
  std::getline(csv, line);  // variant,run,seed,metric,value,unit
  while (std::getline(csv, line)) {
    std::istringstream cells(line);
    std::string variant, run, seed, metric, value;
    for (auto* cell : {&variant, &run, &seed, &metric, &value}) std::getline(cells, *cell, ',');
    Figure& figure = figures[metric];
    figure.mean += std::stod(value);
    ++figure.runs;
  }
  std::filesystem::remove_all(folder);
  if (status != 0) throw std::runtime_error("it failed: " + command);
  for (auto& [metric, figure] : figures) figure.mean /= figure.runs;
  return figures;
}

}  // namespace example
