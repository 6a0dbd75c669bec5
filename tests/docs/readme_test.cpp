// SPDX-License-Identifier: Apache-2.0
// README.md and the pages that begin where it ends: their commands run, print what they show, and their excerpts are those of
// the quickstart and of the first plugin.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "catch.hpp"
#include "document.hpp"
#include "project_folder.hpp"

namespace {

using namespace binnacle::test;
namespace fs = std::filesystem;

const char* const command = "build/release/bin/binnacle";
const char* const quickstart_page = "sdk/docs/quickstart.md";
const char* const plugin_page = "sdk/docs/first-plugin.md";

std::vector<std::string> commands_of(const MarkdownFile& document) {
  std::vector<std::string> found;
  for (const auto& block : document.fences("sh"))
    for (const auto& line : block.lines)
      if (line.rfind(command, 0) == 0) found.push_back(line);
  return found;
}

/// How many excerpts of the page are part of `whole`; each of them is checked.
int excerpts_of(const std::string& whole, const MarkdownFile& page, const std::string& language) {
  int excerpts = 0;
  for (const auto& block : page.fences(language)) {
    ++excerpts;
    INFO(block.text());
    CHECK(whole.find(without_blanks(block.text())) != std::string::npos);
  }
  return excerpts;
}

}  // namespace

TEST_CASE("the commands of the README and of the quickstart's page exit with 0") {
  for (const char* page : {"README.md", quickstart_page}) {
    const ProjectFolder root;
    const auto commands = commands_of(MarkdownFile(page));
    REQUIRE(commands.size() >= 3);
    for (const auto& line : commands) {
      std::string output;
      const int status = root.run(line, output);
      INFO(page << ": " << line << "\n" << output);
      CHECK(status == 0);
    }
  }
}

TEST_CASE("what the README and its first pages show after a $ is what is printed") {
  int shown = 0;
  for (const char* page : {"README.md", quickstart_page, plugin_page})
    for (const auto& block : MarkdownFile(page).fences("text")) {
      if (block.lines.front().rfind("$ ", 0) != 0) continue;
      ++shown;
      std::string script, expected, output;
      for (const auto& line : block.lines) {
        const bool is_typed = line.rfind("$ ", 0) == 0;
        (is_typed ? script : expected) += (is_typed ? line.substr(2) : line) + "\n";
      }
      ProjectFolder().run(script, output);
      INFO(page << ": " << script);
      CHECK(without_times(output) == without_times(expected));
    }
  CHECK(shown == 4);
}

TEST_CASE("excerpts of the README and of the quickstart's page are part of the quickstart and of the first plugin") {
  const std::string quickstart = without_blanks(text_of(in_project("configs/quickstart.json")));
  CHECK(excerpts_of(quickstart, MarkdownFile("README.md"), "json") == 1);
  CHECK(excerpts_of(quickstart, MarkdownFile(quickstart_page), "json") > 5);
  const std::string plugin = without_blanks(MarkdownFile(plugin_page).fences("cpp").front().text());
  CHECK(excerpts_of(plugin, MarkdownFile("README.md"), "cpp") == 1);
}

TEST_CASE("the README has at most 250 lines") {
  const std::string text = text_of(in_project("README.md"));
  CHECK(std::count(text.begin(), text.end(), '\n') <= 250);
}

TEST_CASE("links between the documents lead somewhere") {
  std::vector<std::string> documents{"README.md",
                                     quickstart_page,
                                     plugin_page,
                                     "sdk/docs/summary.md",
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
