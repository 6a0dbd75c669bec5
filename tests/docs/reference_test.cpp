// SPDX-License-Identifier: Apache-2.0
// The reference that the build makes, sdk/docs/reference.md of an installation: every type that is registered, and the keys.
#include <set>
#include <sstream>
#include <string>

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "document.hpp"
#include "project_folder.hpp"

namespace reference_test {

namespace {

using namespace binnacle::test;

/// "core/vector" and its like, as `binnacle list` names them.
std::set<std::string> listed_types() {
  std::string printed;
  REQUIRE(ProjectFolder().run("build/release/bin/binnacle list --json", printed) == 0);
  std::set<std::string> names;
  for (const auto& type : nlohmann::json::parse(printed)) names.insert(type.at("name").get<std::string>());
  return names;
}

/// Headings of the page that are a type's.
std::set<std::string> types_in(const std::string& page) {
  std::set<std::string> names;
  std::istringstream stream(page);
  for (std::string line; std::getline(stream, line);)
    if (line.rfind("### ", 0) == 0) names.insert(line.substr(4));
  return names;
}

}  // namespace

TEST_CASE("the reference that the build made has every registered type and the keys of a config") {
  const std::string page = text_of(DOCS_REFERENCE);
  const auto types = listed_types();
  CHECK(types.size() > 80);
  CHECK(types_in(page) == types);
  for (const char* heading : {"# Config reference", "## The config", "## A filter", "## Every state block",
                              "## Every measurement", "## `reference`", "## `evaluate`"})
    CHECK(("\n" + page).find("\n" + std::string(heading) + "\n") != std::string::npos);
  // Without a type it is seen.
  const auto at = page.find("\n### core/vector\n");
  REQUIRE(at != std::string::npos);
  CHECK(types_in(page.substr(0, at) + page.substr(at + 16)) != types);
}

}  // namespace reference_test
