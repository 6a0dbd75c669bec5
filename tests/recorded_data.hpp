// SPDX-License-Identifier: Apache-2.0
// Where recorded data lie: in $BINNACLE_DATA, else beside the project in ../shared/data. Without any, tests say so and pass.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

namespace binnacle::test {

/// The folder of one kind of data, "drives" or "gnss"; nothing, and a line that says so, where it is not there.
inline std::optional<std::filesystem::path> recorded_data(const char* kind) {
  namespace fs = std::filesystem;
  const char* told = std::getenv("BINNACLE_DATA");
  const fs::path root = told ? fs::path(told) : fs::path(BINNACLE_TEST_PROJECT) / ".." / "shared" / "data";
  const fs::path folder = fs::weakly_canonical(root / kind);
  if (fs::is_directory(folder)) return folder;
  std::printf("SKIPPED: no data (%s is not there; BINNACLE_DATA names another folder)\n", folder.c_str());
  return std::nullopt;
}

}  // namespace binnacle::test
