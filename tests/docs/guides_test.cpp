// SPDX-License-Identifier: Apache-2.0
// sdk/docs: every snippet of a guide is a region of a file that is built and run by tests/package.
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "catch.hpp"
#include "document.hpp"

namespace guides_test {

namespace {

using namespace binnacle::test;
namespace fs = std::filesystem;

const std::vector<std::string> guides{"sdk/docs/write-a-block.md",
                                      "sdk/docs/write-a-process-model.md",
                                      "sdk/docs/write-a-measurement-model.md",
                                      "sdk/docs/write-a-noise-estimator.md",
                                      "sdk/docs/write-a-source.md",
                                      "sdk/docs/ports-and-derived-blocks.md",
                                      "sdk/docs/auxiliary-channels.md",
                                      "sdk/docs/rows.md",
                                      "sdk/docs/test-a-plugin.md",
                                      "sdk/docs/debug-a-plugin.md",
                                      "sdk/docs/units-and-errors.md",
                                      "sdk/docs/abi-rules.md",
                                      "sdk/docs/embed-a-filter.md"};

/// What tests/package builds and runs.
bool is_built(const std::string& file) {
  for (const char* folder : {"sdk/template/", "sdk/examples/", "tests/package/", "tests/plugins/"})
    if (file.rfind(folder, 0) == 0) return true;
  return false;
}

/// Lines with anything but a comment on them.
int lines_of_code(const std::string& path) {
  std::istringstream stream(text_of(in_project(path)));
  int lines = 0;
  for (std::string line; std::getline(stream, line);) {
    const auto code = line.substr(0, line.find("//"));
    lines += code.find_first_not_of(" \t") != std::string::npos;
  }
  return lines;
}

}  // namespace

TEST_CASE("every snippet of a guide is part of a file that is built") {
  for (const auto& path : guides) {
    const auto snippets = MarkdownFile(path).fences();
    INFO(path);
    CHECK_FALSE(snippets.empty());
    for (const auto& snippet : snippets) {
      INFO("from '" << snippet.file << "':\n" << snippet.text());
      REQUIRE(is_built(snippet.file));
      CHECK_FALSE(snippet.lines.empty());
      CHECK(text_of(in_project(snippet.file)).find("\n" + snippet.text()) != std::string::npos);
    }
  }
}

TEST_CASE("the line counts of the guide are those of the templates") {
  const std::string guide = MarkdownFile("sdk/docs/write-a-process-model.md").text();
  for (const char* kind : {"process", "measurement"}) {
    const int lines = lines_of_code(std::string("sdk/template/") + kind + "/plugin.cpp");
    INFO(kind << ": " << lines);
    CHECK(guide.find("| " + std::to_string(lines) + " in one file |") != std::string::npos);
  }
  CHECK(lines_of_code("sdk/template/process/plugin.cpp") <= 30);
}

TEST_CASE("links between the guides lead somewhere") {
  for (const auto& path : guides) {
    const MarkdownFile document(path);
    for (const auto& link : document.links()) {
      INFO(path << " links to " << link);
      CHECK(fs::exists(document.folder() / link));
    }
  }
}

}  // namespace guides_test
