// SPDX-License-Identifier: Apache-2.0
// FolderLock: one process at a time writes into a folder of results.
#pragma once

#include <filesystem>
#include <optional>

#include "unfinished.hpp"

namespace binnacle::command {

/// Holds `FOLDER/.binnacle.lock`, in which the process that has it is named. The lock is the system's (flock) and ends with
/// the process, however that ends; the file, which a killed process leaves behind, means nothing by itself.
class FolderLock {
 public:
  /// Of a folder that is there. Throws UsageError where another process has it, with that process, or where there can be none.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path path_;
  int file_ = -1;
  std::optional<Unfinished> unfinished_;
};

}  // namespace binnacle::command
