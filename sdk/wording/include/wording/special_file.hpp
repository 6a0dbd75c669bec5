// SPDX-License-Identifier: Apache-2.0
// Where a file is meant, a FIFO or a device is refused: nobody may ever write it, or it may never end.
#pragma once

#include <filesystem>

namespace binnacle::wording {

/// It exists and is no regular file, nor a link to one.
inline bool is_special_file(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  return std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
}

}  // namespace binnacle::wording
