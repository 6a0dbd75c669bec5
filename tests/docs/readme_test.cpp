// SPDX-License-Identifier: Apache-2.0
// README.md: its commands run, print what it says they print, and its excerpts are those of the quickstart.
#include <filesystem>
#include <string>
#include <vector>

#include "../recorded_data.hpp"
#include "catch.hpp"
#include "document.hpp"
#include "project_folder.hpp"

namespace {

using namespace binnacle::test;
namespace fs = std::filesystem;

const char* const command = "build/release/bin/binnacle";

std::vector<std::string> commands_of(const MarkdownFile& document, bool with_data) {
  std::vector<std::string> found;
  for (const auto& block : document.fences("sh"))
    for (const auto& line : block.lines)
      if (line.rfind(command, 0) == 0 && (line.find("--var drives=") != std::string::npos) == with_data)
        found.push_back(line);
  return found;
}

}  // namespace

TEST_CASE("the commands of the README exit with 0") {
  const ProjectFolder root;
  const auto commands = commands_of(MarkdownFile("README.md"), false);
  REQUIRE(commands.size() > 5);
  for (const auto& line : commands) {
    std::string output;
    const int status = root.run(line, output);
    INFO(line << "\n" << output);
    CHECK(status == 0);
  }
}

TEST_CASE("the commands of the README on recorded drives exit with 0") {
  const std::string folder = "../shared/data/drives";
  const auto commands = commands_of(MarkdownFile("README.md"), true);
  REQUIRE_FALSE(commands.empty());
  const auto data = recorded_data("drives");
  if (!data) return;
  const ProjectFolder root;
  for (std::string line : commands) {
    REQUIRE(line.find(folder) != std::string::npos);
    line.replace(line.find(folder), folder.size(), data->string());
    std::string output;
    const int status = root.run(line, output);
    INFO(line << "\n" << output);
    CHECK(status == 0);
  }
}

TEST_CASE("what the README shows after a $ is what is printed") {
  int shown = 0;
  for (const auto& block : MarkdownFile("README.md").fences("text")) {
    if (block.lines.front().rfind("$ ", 0) != 0) continue;
    ++shown;
    std::string script, expected, output;
    for (const auto& line : block.lines) {
      const bool is_typed = line.rfind("$ ", 0) == 0;
      (is_typed ? script : expected) += (is_typed ? line.substr(2) : line) + "\n";
    }
    ProjectFolder().run(script, output);
    INFO(script);
    CHECK(without_times(output) == without_times(expected));
  }
  CHECK(shown == 4);
}

TEST_CASE("every JSON excerpt of the README is part of the quickstart") {
  const std::string quickstart = without_blanks(text_of(in_project("configs/quickstart.json")));
  int excerpts = 0;
  for (const auto& block : MarkdownFile("README.md").fences("json")) {
    if (block.lines.front().rfind("// ranges.json:", 0) == 0) continue;
    ++excerpts;
    INFO(block.text());
    CHECK(quickstart.find(without_blanks(block.text())) != std::string::npos);
  }
  CHECK(excerpts > 5);
}

TEST_CASE("links between the documents lead somewhere") {
  std::vector<std::string> documents{"README.md",
                                     "kernel/DESIGN.md",
                                     "configs/README.md",
                                     "configs/drives/README.md",
                                     "configs/faults/README.md",
                                     "configs/gallery/README.md",
                                     "sdk/docs/diagnostics.md"};
  for (const auto& plugin : fs::directory_iterator(in_project("plugins")))
    if (fs::exists(plugin.path() / "README.md"))
      documents.push_back("plugins/" + plugin.path().filename().string() + "/README.md");
  for (const auto& path : documents) {
    const MarkdownFile document(path);
    for (const auto& link : document.links()) {
      INFO(path << " links to " << link);
      CHECK(fs::exists(document.folder() / link));
    }
  }
}
