// SPDX-License-Identifier: Apache-2.0
// README.md and the pages that begin where it ends: their excerpts are those of the quickstart and of the first plugin.
#include <filesystem>
#include <string>
#include <vector>

#include "catch.hpp"
#include "document.hpp"

namespace readme_test {

namespace {

using namespace binnacle::test;
namespace fs = std::filesystem;

const char* const quickstart_page = "sdk/docs/quickstart.md";
const char* const plugin_page = "sdk/docs/first-plugin.md";

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

TEST_CASE("excerpts of the README and of the quickstart's page are part of the quickstart and of the first plugin") {
  const std::string quickstart = without_blanks(text_of(in_project("configs/quickstart.json")));
  CHECK(excerpts_of(quickstart, MarkdownFile("README.md"), "json") == 1);
  CHECK(excerpts_of(quickstart, MarkdownFile(quickstart_page), "json") > 5);
  const auto code = MarkdownFile(plugin_page).fences("cpp");
  const auto excerpts = MarkdownFile("README.md").fences("cpp");
  REQUIRE(excerpts.size() == 2);
  CHECK(without_blanks(code.front().text()).find(without_blanks(excerpts[0].text())) != std::string::npos);
  // Lines of two programs, in C++ and C.
  const std::string programs = without_blanks(code.at(1).text() + text_of(in_project("tests/package/embed_c/main.c")));
  std::size_t at = 0;
  for (const auto& line : excerpts[1].lines) {
    INFO(line);
    at = programs.find(without_blanks(line), at);
    REQUIRE(at != std::string::npos);
  }
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

}  // namespace readme_test
