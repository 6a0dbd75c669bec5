// SPDX-License-Identifier: Apache-2.0
// What is in the making, for an end of the process that no destructor sees: a watchdog's, or exit() in a plugin.
#pragma once

#include <filesystem>
#include <list>

namespace binnacle::command {

/// A file or an empty folder that an early end removes. Out of scope, it is somebody else's.
class Unfinished {
 public:
  /// `topmost`: a folder whose empty subfolders, from `path` upwards, go as well, and itself; empty: `path` is a file.
  explicit Unfinished(std::filesystem::path path, std::filesystem::path topmost = {});
  ~Unfinished();
  Unfinished(const Unfinished&) = delete;
  Unfinished& operator=(const Unfinished&) = delete;

  /// The newest first. For any thread, once; whatever is made or given up later waits until the process has ended.
  static void remove_all() noexcept;

  struct Entry {
    std::filesystem::path path, topmost;
  };

 private:
  std::list<Entry>::iterator entry_;
};

/// The folder if it is empty, then those above it that are empty, up to `topmost`.
void remove_empty_folders(std::filesystem::path from, const std::filesystem::path& topmost);

}  // namespace binnacle::command
