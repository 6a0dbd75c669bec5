// SPDX-License-Identifier: Apache-2.0
// Every Markdown page of the project: its commands run and print what it shows. A new page is typed without being listed.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <unistd.h>

#include "catch.hpp"
#include "document.hpp"
#include "page_session.hpp"
#include "skip.hpp"
#include "typed_elsewhere.hpp"

namespace pages_test {

namespace {

using namespace binnacle::test;
namespace fs = std::filesystem;

/// Paths of all pages, sorted.
std::vector<std::string> pages() {
  std::vector<std::string> found;
  const fs::path project = BINNACLE_TEST_PROJECT;
  for (fs::recursive_directory_iterator at(project), end; at != end; ++at) {
    const auto name = at->path().filename().string();
    const bool is_foreign = name == "build" || name == "bad" || name.front() == '.';
    if (is_foreign && at->is_directory()) at.disable_recursion_pending();
    if (at->is_regular_file() && at->path().extension() == ".md")
      found.push_back(at->path().lexically_relative(project).string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// Test cases by what their pages' paths begin with: the first that matches has a page, and the last matches all. Those that
/// serve the port of configs/live/output.json are one: cases run at the same time.
const std::vector<std::string> groups{
    "(configs|sdk/docs)/live", "configs/[a-b]",      "configs/[c-f]",  "configs/[g-l]", "configs/",
    "sdk/docs/verbs/",         "sdk/docs/evidence/", "sdk/docs/[a-l]", "sdk/docs/",     ""};

std::string group_of(const std::string& page) {
  return *std::find_if(groups.begin(), groups.end(),
                       [&](const auto& group) { return std::regex_search(page, std::regex("^" + group)); });
}

void type_group(const std::string& group) {
  int commands = 0;
  std::vector<std::string> without_data;
  for (const auto& path : pages()) {
    if (group_of(path) != group) continue;
    const MarkdownFile page(path);
    commands += static_cast<int>(commands_in(page).size());
    INFO(path);
    const auto [faults, untried] = session_of(page);
    for (const auto& fault : faults) FAIL_CHECK(fault);
    without_data.insert(without_data.end(), untried.begin(), untried.end());
  }
  CHECK(commands > 0);
  if (!without_data.empty())
    skip("no data for " + std::to_string(without_data.size()) + " of the commands: " + without_data.front());
}

/// Commands that no session sees: of an indented block, which may only show a form with words such as CONFIG, and of a fence
/// in another language than `sh`.
std::vector<std::string> unseen_commands(const std::string& path) {
  const std::string programs =
      R"((\$ |binnacle [a-z]|build/release/bin/|(tests|sdk|configs)/([a-z_]+/)*[a-z_]+(\.sh|\.py)?( |$)|(cmake|ctest|ninja|python3) ))";
  static const std::regex indented("^    " + programs), form(R"(\b[A-Z]{4,}\b)"), typed("^" + programs),
      outcome(R"(: exit status \d+$)");  // what a test printed about a command
  std::vector<std::string> found;
  std::istringstream stream(text_of(in_project(path)));
  const bool is_verb = path.rfind("sdk/docs/verbs/", 0) == 0;  // shows its form
  for (std::string line; std::getline(stream, line);)
    if (std::regex_search(line, indented) && !is_verb && !std::regex_search(line, form)) found.push_back(line);
  for (const auto& fence : MarkdownFile(path).fences()) {
    if (fence.language == "sh" || is_shown(fence)) continue;
    for (const auto& line : fence.lines)
      if (std::regex_search(line, typed) && !std::regex_search(line, outcome)) found.push_back(line);
  }
  return found;
}

/// Whether a test case, in any file of tests, is named so.
bool is_test_case(const std::string& begin) {
  for (const auto& entry : fs::recursive_directory_iterator(in_project("tests")))
    if (entry.path().extension() == ".cpp" && text_of(entry.path()).find("\"" + begin) != std::string::npos)
      return true;
  return false;
}

}  // namespace

TEST_CASE("what pages about live runs say to type works and prints what they show") {
  type_group("(configs|sdk/docs)/live");
}
TEST_CASE("what pages of configs A to B say to type works and prints what they show") { type_group("configs/[a-b]"); }
TEST_CASE("what pages of configs C to F say to type works and prints what they show") { type_group("configs/[c-f]"); }
TEST_CASE("what pages of configs G to L say to type works and prints what they show") { type_group("configs/[g-l]"); }
TEST_CASE("what pages of configs M to Z say to type works and prints what they show") { type_group("configs/"); }
TEST_CASE("what pages of the verbs say to type works and prints what they show") { type_group("sdk/docs/verbs/"); }
TEST_CASE("what pages of the evidence say to type works and prints what they show") {
  type_group("sdk/docs/evidence/");
}
TEST_CASE("what pages A to L of the manual say to type works and prints what they show") {
  type_group("sdk/docs/[a-l]");
}
TEST_CASE("what pages M to Z of the manual say to type works and prints what they show") { type_group("sdk/docs/"); }
TEST_CASE("what all other pages say to type works and prints what they show") { type_group(""); }

TEST_CASE("no page has a command that no test types") {
  for (const auto& path : pages()) {
    INFO(path << ": put commands into a fence of the language sh, or behind a $ into one of the language text");
    for (const auto& line : unseen_commands(path)) FAIL_CHECK(line);
    for (const auto& fence : MarkdownFile(path).fences("sh"))
      if (!fence.file.empty()) CHECK(text_of(in_project(fence.file)).find("\n" + fence.text()) != std::string::npos);
  }
}

TEST_CASE("a page with a command that no test types is refused") {
  const fs::path path = fs::temp_directory_path() / ("binnacle-page-" + std::to_string(::getpid()) + ".md");
  const auto unseen = [&](const std::string& text) {
    std::ofstream(path) << text;
    const auto found = unseen_commands(path.string());
    fs::remove(path);
    return found.size();
  };
  CHECK(unseen("    binnacle run configs/quickstart.json\n") == 1);
  CHECK(unseen("    tests/compare/run\n") == 1);
  CHECK(unseen("```bash\nbinnacle list\n```\n") == 1);
  CHECK(unseen("```\nbuild/release/bin/binnacle list\n```\n") == 1);
  CHECK(unseen("```text\nOutput:\n$ binnacle list\n```\n") == 1);
  CHECK(unseen("```text\ncmake -B build\n```\n") == 1);
  CHECK(unseen("```sh\nbinnacle list\n```\n    binnacle run CONFIG\n") == 0);
  CHECK(unseen("```text\n$ binnacle list\n```\n") == 0);
}

TEST_CASE("what no session types is typed by the test that stands beside it") {
  std::vector<std::string> commands;
  for (const auto& path : pages())
    for (const auto& command : commands_in(MarkdownFile(path))) commands.push_back(command);
  for (const auto& entry : typed_elsewhere()) {
    INFO(entry.pattern << ": " << entry.test);
    CHECK(text_of(in_project(entry.test)).find(entry.words) != std::string::npos);
    CHECK(std::any_of(commands.begin(), commands.end(),
                      [&](const auto& line) { return typed_elsewhere(line) == &entry; }));
  }
  static const std::regex tests(R"re(^build/release/bin/[a-z]+_tests "([^*"]+))re");
  for (const auto& line : commands) {
    std::smatch found;
    INFO(line);
    if (std::regex_search(line, found, tests)) CHECK(is_test_case(found[1]));
  }
}

TEST_CASE("folders of new plugins have the commands of the one that a test types") {
  const auto typed = commands_in(MarkdownFile("sdk/template/process/README.md"));
  CHECK(typed.size() == 4);
  for (const auto& entry : fs::directory_iterator(in_project("sdk/template"))) {
    INFO(entry.path());
    if (fs::exists(entry.path() / "README.md")) CHECK(commands_in(MarkdownFile(entry.path() / "README.md")) == typed);
  }
}

}  // namespace pages_test
