// SPDX-License-Identifier: Apache-2.0
// Workbench: a temporary folder with a small config that runs, its data, and ways to spoil them.
#pragma once

#include <filesystem>
#include <string>

namespace binnacle::test {

/// A place that wanders by a random walk, seen in five fixes and judged by three samples of truth.
extern const char* const good_config;

std::string read_file(const std::filesystem::path& path);

class Workbench {
 public:
  /// Holds good.json, fix.csv and truth.csv.
  Workbench();
  ~Workbench();
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  /// As the command prints it: symlinks resolved.
  std::string folder() const { return folder_.string(); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  /// Not in the folder itself, which the tests look at.
  std::string beside(const std::string& name) const { return folder_.string() + "." + name; }
  void write(const std::string& name, const std::string& text) const;
  void write_gzip(const std::string& name, const std::string& text) const;
  /// bad.json: the good config with the first `from` replaced, which must be there.
  void spoil(const std::string& from, const std::string& to) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace binnacle::test
