// SPDX-License-Identifier: Apache-2.0
// sdk/docs/diagnostics.md explains every code that is in the sources, and no other.
#include <algorithm>
#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "catch.hpp"
#include "document.hpp"

namespace diagnostics_test {

using namespace binnacle::test;

namespace {

std::string page() { return text_of(in_project("sdk/docs/diagnostics.md")); }

/// Codes as string literals of the C++ of a folder.
void collect(const std::string& folder, std::set<std::string>& codes) {
  static const std::regex literal("\"(B[0-9]{3})\"");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(in_project(folder))) {
    const std::string ending = entry.path().extension().string();
    if (ending != ".cpp" && ending != ".hpp") continue;
    const std::string text = text_of(entry.path());
    for (std::sregex_iterator at(text.begin(), text.end(), literal), end; at != end; ++at) codes.insert((*at)[1]);
  }
}

}  // namespace

TEST_CASE("each code has a title, a cause and a remedy, and they are sorted") {
  static const std::regex entry("\n## (B[0-9]{3}): [^\n]+\n\n[^\n]+\n\n\\*Remedy:\\* [^\n]+\n"), heading("\n## ");
  const std::string text = page();
  std::vector<std::string> codes;
  for (std::sregex_iterator at(text.begin(), text.end(), entry), end; at != end; ++at) codes.push_back((*at)[1]);
  CHECK(codes.size() >= 90);
  CHECK(std::distance(std::sregex_iterator(text.begin(), text.end(), heading), std::sregex_iterator()) ==
        std::ssize(codes));
  CHECK(std::ranges::is_sorted(codes));
  CHECK(std::ranges::adjacent_find(codes) == codes.end());
}

TEST_CASE("every code of the sources is explained, and no other") {
  std::set<std::string> used, explained;
  for (const char* folder : {"kernel", "sdk", "plugins"}) collect(folder, used);
  static const std::regex heading("\n## (B[0-9]{3}): ");
  const std::string text = page();
  for (std::sregex_iterator at(text.begin(), text.end(), heading), end; at != end; ++at) explained.insert((*at)[1]);
  for (const auto& code : used) {
    INFO(code);
    CHECK(explained.contains(code));
  }
  for (const auto& code : explained) {
    INFO(code);
    CHECK(used.contains(code));
  }
}

}  // namespace diagnostics_test
