// SPDX-License-Identifier: Apache-2.0
// sdk/docs/results.md: its commands and its Python run and print what the guide says they print.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <sys/wait.h>

#include "catch.hpp"
#include "document.hpp"
#include "skip.hpp"

namespace results_guide_test {

namespace {

using namespace binnacle::test;
namespace fs = std::filesystem;

/// A folder with the project's configs, where `binnacle` is on the PATH.
class Workspace {
 public:
  Workspace() {
    std::string name = (fs::temp_directory_path() / "binnacle-guide.XXXXXX").string();
    if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
    folder_ = name;
    fs::create_symlink(in_project("configs"), folder_ / "configs");
  }
  ~Workspace() { fs::remove_all(folder_); }
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  /// Exit status; `output` is stdout and stderr together.
  int run(const std::string& script, std::string& output) const {
    const std::string line = "cd '" + folder_.string() + "' && export LC_ALL=C PATH='" +
                             fs::path(DOCS_COMMAND).parent_path().string() + "':\"$PATH\" && { " + script + "\n} 2>&1";
    FILE* const pipe = ::popen(line.c_str(), "r");
    if (!pipe) throw std::runtime_error("no shell");
    output.clear();
    for (int c = 0; (c = std::fgetc(pipe)) != EOF;) output += static_cast<char>(c);
    const int status = ::pclose(pipe);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  int run_python(const std::string& script, std::string& output) const {
    std::ofstream(folder_ / "guide.py") << script;
    return run(DOCS_PYTHON " guide.py", output);
  }

 private:
  fs::path folder_;
};

bool is_there(const Workspace& workspace, const std::string& module) {
  std::string output;
  return workspace.run_python("import " + module + "\n", output) == 0;
}

}  // namespace

TEST_CASE("what the guide to results shows is what is printed") {
  const MarkdownFile guide("sdk/docs/results.md");
  const Workspace workspace;
  std::string output;
  const auto texts = guide.fences("text");
  std::size_t typed = 0;
  std::vector<std::string> printed;  // by Python, in its order
  for (const auto& block : texts) {
    if (block.lines.front().rfind("$ ", 0) != 0) {
      printed.push_back(block.text());
      continue;
    }
    std::string script, expected;
    for (const auto& line : block.lines) {
      const bool is_typed = line.rfind("$ ", 0) == 0;
      (is_typed ? script : expected) += (is_typed ? line.substr(2) : line) + "\n";
    }
    const int status = workspace.run(script, output);
    INFO(script << output);
    CHECK(status == 0);
    CHECK(output == expected);
    ++typed;
  }
  CHECK(typed == 2);

  const auto scripts = guide.fences("python");
  REQUIRE(scripts.size() == printed.size());
  std::string missing;
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    const std::string module = scripts[i].lines.front().substr(std::string("import ").size());
    if (!is_there(workspace, module)) {
      missing += (missing.empty() ? "" : ", ") + module;
      continue;
    }
    const int status = workspace.run_python(scripts[i].text(), output);
    INFO(scripts[i].text() << output);
    CHECK(status == 0);
    CHECK(output == printed[i]);
  }
  const char* const ci = std::getenv("CI");
  if (!missing.empty() && ci && std::string(ci) == "true")
    FAIL("Python has no " << missing << ": see sdk/packages.txt");
  if (!missing.empty()) binnacle::test::skip("not tried, since Python has no " + missing);
}

}  // namespace results_guide_test
