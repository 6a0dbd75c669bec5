// SPDX-License-Identifier: Apache-2.0
// new: what it writes and what it refuses; that it builds and passes is tests/package.
#include "catch.hpp"

#include <algorithm>
#include <filesystem>
#include <set>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "refusal.hpp"

namespace new_test {

using namespace binnacle::test;
namespace fs = std::filesystem;

namespace {

/// With this message as its first line.
void is_refused(const Workbench& bench, const std::vector<std::string>& arguments, const std::string& message) {
  const std::string said = refusal(bench, arguments);
  CHECK(said.substr(0, said.find('\n')) == "error: " + message);
}

}  // namespace

TEST_CASE("new plugin writes a folder for each kind, with the name wherever it belongs") {
  const Workbench bench;
  for (const char* kind : {"block", "process", "measurement", "noise", "derived", "source", "transform", "sink"}) {
    const std::string name = std::string("my_") + kind;
    INFO(name);
    const auto outcome = binnacle::test::binnacle(bench, {"new", "plugin", name, "--kind", kind});
    REQUIRE(outcome.status == 0);
    CHECK(outcome.err.empty());
    const auto files = names_in(bench.path(name));
    for (const char* file : {".gitignore", "CMakeLists.txt", "README.md", "config.json", "plugin.cpp"})
      CHECK(files.contains(file));
    for (const auto& file : files) {
      const std::string text = read_file(bench.path(name + "/" + file));
      INFO(file);
      CHECK(text.find("@NAME@") == std::string::npos);
      CHECK(text.find("SPDX") == std::string::npos);
      if (file.find(".csv") == std::string::npos && file != ".gitignore") CHECK(text.find(name) != std::string::npos);
    }
  }
}

TEST_CASE("new plugin is of kind process in this folder by default, and prints what it wrote") {
  const Workbench bench;
  const auto here = binnacle::test::binnacle(bench, {"new", "plugin", "my_walk"});
  REQUIRE(here.status == 0);
  // From a build tree, which is no installation.
  CHECK(here.out.find("cmake --install ") != std::string::npos);
  CHECK(here.out.find("cmake -B build -DCMAKE_PREFIX_PATH=PREFIX ") != std::string::npos);
  CHECK(read_file(bench.path("my_walk/plugin.cpp")).find("public ProcessModel") != std::string::npos);

  fs::create_directory(bench.path("there"));
  const auto outcome = binnacle::test::binnacle(bench, {"new", "plugin", "my_walk", "--dir", "there", "--json"});
  REQUIRE(outcome.status == 0);
  const auto reported = nlohmann::json::parse(outcome.out);
  CHECK(reported.at("folder") == "there/my_walk");
  const auto files = reported.at("files").get<std::set<std::string>>();
  CHECK(files == names_in(bench.path("there/my_walk")));
}

TEST_CASE("new plugin refuses what could not be built, loaded or told apart") {
  const Workbench bench;
  is_refused(bench, {"new", "plugin", "MyWalk"},
             "'MyWalk' is not a name in snake_case (a-z, 0-9, _); did you mean 'my_walk'?");
  is_refused(bench, {"new", "plugin", "2nd"}, "'2nd' is not a name in snake_case (a-z, 0-9, _)");
  is_refused(bench, {"new", "plugin", "../my_walk"},
             "'../my_walk' is not a name in snake_case (a-z, 0-9, _); did you mean 'my_walk'?");
  is_refused(bench, {"new", "plugin", std::string(49, 'a')}, "the name has 49 characters; 48 are possible");
  is_refused(bench, {"new", "plugin", "test"}, "'test' is the name of one of CMake's own targets; choose another");
  is_refused(bench, {"new", "plugin", "core"},
             "there is a plugin 'core' already; choose another name, such as 'my_core'");
  is_refused(bench, {"new", "plugin", "vector"},
             "there is a component 'core/vector' already; choose another name, such as 'my_vector'");
  is_refused(bench, {"new", "plugin", "my_walk", "--dir", "nowhere"}, "there is no folder 'nowhere'");
  is_refused(bench, {"new", "plugin", "my_walk", "--kind", "proces"},
             "there is no kind 'proces'; did you mean 'process'? (kinds: block, process, measurement, noise, derived, "
             "source, transform, sink)");
  is_refused(bench, {"new", "plugn", "my_walk"}, "there is nothing new called 'plugn'; did you mean 'plugin'?");
}

TEST_CASE("new plugin leaves what exists as it is") {
  const Workbench bench;
  bench.write("my_walk", "mine");
  is_refused(bench, {"new", "plugin", "my_walk"}, "'my_walk' exists already; nothing was written");
  CHECK(read_file(bench.path("my_walk")) == "mine");
}

}  // namespace new_test
