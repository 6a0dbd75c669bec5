// SPDX-License-Identifier: Apache-2.0
#include "project_folder.hpp"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include <sys/wait.h>

#include "../recorded_data.hpp"
#include "document.hpp"

namespace binnacle::test {

namespace fs = std::filesystem;

ProjectFolder::ProjectFolder() {
  std::string name = (fs::temp_directory_path() / "binnacle-docs.XXXXXX").string();
  if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
  above_ = name;
  folder_ = above_ / "project";
  fs::create_directories(folder_ / "build/release/bin");
  fs::create_symlink(DOCS_COMMAND, folder_ / "build/release/bin/binnacle");
  fs::create_directories(folder_ / "build/release/lib");
  fs::create_symlink(BINNACLE_TEST_PLUGINS, folder_ / "build/release/lib/binnacle");
  fs::create_symlink(DOCS_EMBED, folder_ / "embed");
  // A copy: some commands write beside a config.
  fs::copy(in_project("configs"), folder_ / "configs", fs::copy_options::recursive);
  fs::create_symlink(in_project("tests"), folder_ / "tests");
  fs::create_directories(above_ / "shared");
  if (const auto data = recorded_folder(""); fs::is_directory(data)) fs::create_symlink(data, above_ / "shared/data");
  for (const auto& block : MarkdownFile("sdk/docs/first-plugin.md").fences("json"))
    if (block.lines.front().rfind("// ranges.json:", 0) == 0) std::ofstream(folder_ / "ranges.json") << block.text();
}

ProjectFolder::~ProjectFolder() { fs::remove_all(above_); }

bool ProjectFolder::has_folder(const std::string& path) const { return fs::is_directory(folder_ / path); }

int ProjectFolder::run(const std::string& script, std::string& output) const {
  const std::string line = "cd '" + folder_.string() + "' && export NO_COLOR=1 BINNACLE_PLUGIN_PATH='" +
                           BINNACLE_TEST_PLUGINS + "' && { " + script + "\n} 2>&1";
  FILE* pipe = ::popen(line.c_str(), "r");
  if (!pipe) throw std::runtime_error("no shell");
  output.clear();
  char buffer[4096];
  while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) output.append(buffer, n);
  const int status = ::pclose(pipe);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

void ProjectFolder::write(const std::string& name, const std::string& text) const {
  std::ofstream file(folder_ / name, std::ios::binary);
  file << text;
  if (!file.flush()) throw std::runtime_error("cannot write " + name);
}

}  // namespace binnacle::test
