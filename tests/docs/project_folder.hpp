// SPDX-License-Identifier: Apache-2.0
// A folder that looks like the project's root to those who type what the documents say, with recorded data, where there are
// any, in ../shared/data.
#pragma once

#include <filesystem>
#include <string>

namespace binnacle::test {

class ProjectFolder {
 public:
  ProjectFolder();
  ~ProjectFolder();
  ProjectFolder(const ProjectFolder&) = delete;
  ProjectFolder& operator=(const ProjectFolder&) = delete;

  /// Exit status; `output` is stdout and stderr together.
  int run(const std::string& script, std::string& output) const;
  /// A file of that name in the folder.
  void write(const std::string& name, const std::string& text) const;
  const std::filesystem::path& path() const { return folder_; }
  bool has_folder(const std::string& path) const;

 private:
  std::filesystem::path above_;
  std::filesystem::path folder_;
};

}  // namespace binnacle::test
