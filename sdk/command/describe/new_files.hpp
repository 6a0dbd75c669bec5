// SPDX-License-Identifier: Apache-2.0
// NewFiles: files that are written where none was.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace binnacle::command {

/// Written beside their places under hidden names, which commit() gives up. Out of scope without it, nothing is left. No file
/// that exists is replaced, not even one that somebody else makes at the same moment.
class NewFiles {
 public:
  NewFiles() = default;
  ~NewFiles();
  NewFiles(const NewFiles&) = delete;
  NewFiles& operator=(const NewFiles&) = delete;

  /// With the folders above it. UsageError where something is at `target`; OutputError where it cannot be written.
  void write(const std::filesystem::path& target, const std::string& text);
  /// In the order of write(). Where one fails, those before it go again.
  void commit();

 private:
  struct File {
    std::filesystem::path target, temporary;
    std::filesystem::path topmost;  // of the folders made for it; empty: none
    bool is_there = false;
  };
  std::vector<File> files_;
  bool is_kept_ = false;
};

}  // namespace binnacle::command
