// SPDX-License-Identifier: Apache-2.0
#include "installation.hpp"

#include <fmt/format.h>

#include "output.hpp"

namespace binnacle::command {

namespace fs = std::filesystem;

fs::path program_folder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

fs::path prefix() { return program_folder().parent_path(); }

fs::path shared_folder(const fs::path& folder, const char* what) {
  std::error_code error;
  const fs::path found = prefix() / "share" / "binnacle" / folder;
  if (!fs::is_directory(found, error))
    throw UsageError(fmt::format("the {} are missing: there is no folder '{}'", what, found.string()));
  return found;
}

}  // namespace binnacle::command
