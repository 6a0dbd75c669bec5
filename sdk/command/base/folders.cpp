// SPDX-License-Identifier: Apache-2.0
#include "folders.hpp"

#include <fmt/format.h>

#include "output.hpp"

namespace binnacle::command {

namespace fs = std::filesystem;

fs::path make_folders(const fs::path& folder) {
  fs::path made;
  std::error_code error;
  for (fs::path at = folder; !at.empty() && !fs::exists(at, error); at = at.parent_path()) made = at;
  if (!fs::create_directories(folder, error) && !fs::is_directory(folder)) {
    if (!error) error = std::make_error_code(std::errc::not_a_directory);
    throw UsageError(fmt::format("cannot make the folder '{}': {}", folder.string(), error.message()));
  }
  return made;
}

}  // namespace binnacle::command
