// SPDX-License-Identifier: Apache-2.0
// Where recorded data lie: in $BINNACLE_DATA, else beside the project in ../shared/data. A test without its
// data is skipped.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include "skip.hpp"

namespace binnacle::test {

/// Where the data of one kind, "drives" or "gnss", have to be.
inline std::filesystem::path recorded_folder(const std::string& kind) {
  namespace fs = std::filesystem;
  const char* named = std::getenv("BINNACLE_DATA");
  const fs::path root = named ? fs::path(named) : fs::path(BINNACLE_TEST_PROJECT) / ".." / "shared" / "data";
  return fs::weakly_canonical(root / kind);
}

/// That folder. Where it is not there, nothing, and the running test is skipped.
inline std::optional<std::filesystem::path> recorded_data(const std::string& kind) {
  const auto folder = recorded_folder(kind);
  if (std::filesystem::is_directory(folder)) return folder;
  skip("no data (" + folder.string() + " is not there; BINNACLE_DATA names another folder)");
  return std::nullopt;
}

}  // namespace binnacle::test
