// SPDX-License-Identifier: Apache-2.0
// A command that is refused leaves its folder as it was.
#pragma once

#include "catch.hpp"

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "command.hpp"

namespace binnacle::test {

inline std::set<std::string> names_in(const std::filesystem::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

/// What it says. Exit status 2, nothing on stdout, and not a file more or less than before.
inline std::string refusal(const Workbench& bench, const std::vector<std::string>& arguments) {
  const auto before = names_in(bench.folder());
  const auto outcome = binnacle(bench, arguments);
  CHECK(outcome.status == 2);
  CHECK(outcome.out.empty());
  CHECK(names_in(bench.folder()) == before);
  return outcome.err;
}

}  // namespace binnacle::test
