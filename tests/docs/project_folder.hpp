// SPDX-License-Identifier: Apache-2.0
// A folder that looks like the project's root to those who type what the documents say.
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

 private:
  std::filesystem::path folder_;
};

}  // namespace binnacle::test
