// SPDX-License-Identifier: Apache-2.0
// The manual, sdk/docs: its pages name every option that there is, and its excerpts and figures are those of the configs.
#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "catch.hpp"
#include "document.hpp"
#include "page_session.hpp"
#include "project_folder.hpp"

namespace manual_test {

namespace {

using namespace binnacle::test;
namespace fs = std::filesystem;

const std::string verbs_folder = "sdk/docs/verbs";

std::vector<std::string> verb_pages() {
  std::vector<std::string> verbs;
  for (const auto& entry : fs::directory_iterator(in_project(verbs_folder)))
    verbs.push_back(entry.path().stem().string());
  std::sort(verbs.begin(), verbs.end());
  return verbs;
}

MarkdownFile page_of(const std::string& verb) { return MarkdownFile(verbs_folder + "/" + verb + ".md"); }

std::set<std::string> matches(const std::string& text, const std::regex& pattern) {
  std::set<std::string> found;
  for (std::sregex_iterator at(text.begin(), text.end(), pattern), end; at != end; ++at) found.insert((*at)[1]);
  return found;
}

std::string help_of(const ProjectFolder& root, const std::string& verb) {
  std::string text;
  root.run("build/release/bin/binnacle " + verb + " --help", text);
  return text;
}

/// "--json" and its like, where `--help` lists them.
std::set<std::string> options_of(const std::string& help) {
  auto found = matches(help, std::regex(R"(\n\s+(?:-\w,)?(?:--[a-z-]+,)?(--[a-z-]+))"));
  found.merge(matches(help, std::regex(R"(\n\s+(--[a-z-]+),--)")));
  found.erase("--help");
  return found;
}

/// Options in the first column of the page's tables.
std::set<std::string> options_in(const std::string& page) {
  std::set<std::string> found;
  std::istringstream stream(page);
  for (std::string line; std::getline(stream, line);)
    if (line.rfind("| `--", 0) == 0) found.merge(matches(line.substr(0, line.find(" | ")), std::regex("`(--[a-z-]+)")));
  return found;
}

std::vector<std::string> guides() {
  std::vector<std::string> found{"README", "tutorial", "live-output"};
  for (const auto& entry : fs::directory_iterator(in_project("sdk/docs/evidence")))
    found.push_back("evidence/" + entry.path().stem().string());
  for (const auto& verb : verb_pages()) found.push_back("verbs/" + verb);
  return found;
}

}  // namespace

TEST_CASE("every JSON excerpt of the tutorial is part of its config") {
  const std::string config = without_blanks(text_of(in_project("configs/tutorial/drive.json")));
  int excerpts = 0;
  for (const auto& block : MarkdownFile("sdk/docs/tutorial.md").fences("json")) {
    if (block.lines.front().rfind("// ", 0) == 0) continue;
    ++excerpts;
    INFO(block.text());
    CHECK(config.find(without_blanks(block.text())) != std::string::npos);
  }
  CHECK(excerpts > 4);
}

TEST_CASE("every verb has a page, which names its options and no others") {
  const ProjectFolder root;
  const auto verbs = matches(help_of(root, ""), std::regex(R"(\n  ([a-z]+)  )"));
  REQUIRE(verbs.size() > 10);
  const auto pages = verb_pages();
  for (const auto& verb : verbs) {
    INFO(verb);
    REQUIRE(std::count(pages.begin(), pages.end(), verb) == 1);
    CHECK_FALSE(commands_in(page_of(verb)).empty());
    const auto there_are = options_of(help_of(root, verb)), listed = options_in(page_of(verb).text());
    REQUIRE_FALSE(there_are.empty());
    for (const auto& option : there_are) {
      INFO(option << " is an option, and the page does not list it");
      CHECK(listed.count(option) == 1);
    }
    for (const auto& option : listed) {
      INFO("the page lists " << option << ", which is no option");
      CHECK(there_are.count(option) == 1);
    }
  }
}

TEST_CASE("figures in the page of the papers are those of the configs' READMEs") {
  std::istringstream stream(text_of(in_project("sdk/docs/evidence/papers.md")));
  static const std::regex source(R"(\((\.\./\.\./\.\./configs/[a-z_]+/README\.md)\))"), number(R"([0-9]+\.[0-9]+)");
  std::string readmes;
  int figures = 0;
  bool is_new_section = false;
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("## ", 0) == 0) is_new_section = true;
    for (std::sregex_iterator at(line.begin(), line.end(), source), end; at != end; ++at) {
      if (is_new_section) readmes.clear();
      is_new_section = false;
      readmes += text_of(in_project("sdk/docs/evidence/" + at->str(1)));
    }
    if (line.rfind("| ", 0) != 0) continue;
    for (std::sregex_iterator at(line.begin(), line.end(), number), end; at != end; ++at, ++figures) {
      INFO(at->str() << " in: " << line);
      CHECK(std::regex_search(
          readmes, std::regex("(^|[^0-9.])" + std::regex_replace(at->str(), std::regex("\\."), "\\.") + "($|[^0-9])")));
    }
  }
  CHECK(figures > 50);
}

TEST_CASE("the configs that the page of the papers names are right") {
  const ProjectFolder root;
  const std::string page = MarkdownFile("sdk/docs/evidence/papers.md").text();
  const auto configs = matches(page, std::regex(R"((configs/[a-z0-9_/-]+\.json))"));
  REQUIRE(configs.size() >= 10);
  for (const auto& config : configs) {
    INFO(config);
    CHECK(fs::exists(in_project(config)));
  }
}

TEST_CASE("links of the manual lead somewhere") {
  for (const auto& name : guides()) {
    const MarkdownFile document("sdk/docs/" + name + ".md");
    for (const auto& link : document.links()) {
      INFO(name << ".md links to " << link);
      CHECK(fs::exists(document.folder() / link));
    }
  }
}

}  // namespace manual_test
