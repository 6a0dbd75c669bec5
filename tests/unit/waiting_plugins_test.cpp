// SPDX-License-Identifier: Apache-2.0
// Plugins that list their types, and wait until one of them is wanted; BINNACLE_LOADER_TEST_PLUGINS is their place.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "binnacle/catalog.hpp"
#include "catch.hpp"
#include "loader_work.hpp"

namespace waiting_plugins_test {

using namespace binnacle;
using namespace loader_work;

namespace {

/// Copies of those plugins alone, and a catalog in which what lists its types waits.
struct Waiting {
  explicit Waiting(const std::vector<std::string>& names) {
    ::unsetenv("BINNACLE_TEST_LISTED_LOADED");
    for (const auto& name : names) fs::copy_file(plugin_at(name), scratch.path / (name + ".so"));
    Diagnostics diagnostics;
    catalog.load_search_path({}, diagnostics, {scratch.path}, Catalog::Loading::when_wanted);
    CHECK(diagnostics.text() == "");
  }
  /// What is said of a type that is wanted; "" where it is found.
  std::string want(Role role, const std::string& name) {
    Diagnostics diagnostics;
    const bool is_found = catalog.want(role, name, {"c.json", 3, 5}, "/x/type", diagnostics);
    CHECK(is_found != diagnostics.has_errors());
    std::string text = diagnostics.text();
    const std::string prefix = scratch.path.string() + "/";
    for (std::size_t at = 0; (at = text.find(prefix, at)) != std::string::npos;) text.erase(at, prefix.size());
    return text;
  }
  static bool is_loaded() { return ::getenv("BINNACLE_TEST_LISTED_LOADED") != nullptr; }

  Scratch scratch;
  Catalog catalog;
};

Lines names_of(const std::vector<PluginInfo>& plugins) {
  Lines names;
  for (const auto& plugin : plugins) names.push_back(plugin.name + " " + plugin.version);
  return names;
}

}  // namespace

TEST_CASE("a plugin that lists its types waits until one of them is wanted", "[catalog]") {
  Waiting waiting({"listed", "good"});
  CHECK_FALSE(Waiting::is_loaded());
  // It is one of the plugins, as if it were loaded: what results and snapshots say of plugins does not depend on use.
  CHECK(names_of(waiting.catalog.plugins()) == Lines{"good 1.2.3", "listed 2.0.0"});
  CHECK(waiting.want(Role::source, "thrower") == "");
  CHECK(waiting.want(Role::state_block, "good/still") == "");
  CHECK_FALSE(Waiting::is_loaded());
  CHECK(waiting.catalog.types().size() == 3);

  CHECK(waiting.want(Role::state_block, "listed/still") == "");
  CHECK(Waiting::is_loaded());
  CHECK(waiting.catalog.types().size() == 5);
  CHECK(names_of(waiting.catalog.plugins()) == Lines{"good 1.2.3", "listed 2.0.0"});
}

TEST_CASE("whatever is said of a name is said of plugins that wait too", "[catalog]") {
  SECTION("ambiguous") {
    CHECK(Waiting({"listed", "good"}).want(Role::state_block, "still") ==
          "c.json:3:5: error[B022] /x/type: 'still' is ambiguous; write 'good/still' or 'listed/still'");
  }
  SECTION("misspelt") {
    CHECK(Waiting({"listed"}).want(Role::process_model, "rset") ==
          "c.json:3:5: error[B011] /x/type: unknown process model 'rset'; did you mean 'rest'?");
  }
  SECTION("renamed") {
    CHECK(Waiting({"listed"}).want(Role::state_block, "old_home/still") ==
          "c.json:3:5: error[B011] /x/type: 'old_home/still' is now called 'listed/still'");
  }
  SECTION("of another role") {
    CHECK(Waiting({"listed"}).want(Role::sink, "rest") ==
          "c.json:3:5: error[B011] /x/type: 'rest' is a process model, not a sink");
  }
  SECTION("nobody's") {
    CHECK(Waiting({"listed"}).want(Role::sink, "recorder") ==
          "c.json:3:5: error[B011] /x/type: unknown sink 'recorder'; none of the loaded plugins has it: listed");
  }
  CHECK(Waiting::is_loaded());
}

TEST_CASE("what waits is loaded at once where it is named, or where all is asked for", "[catalog]") {
  Diagnostics diagnostics;
  SECTION("by its file") {
    Waiting waiting({"listed"});
    waiting.catalog.load(waiting.scratch.path / "listed.so", diagnostics);
    CHECK(waiting.catalog.types().size() == 2);
  }
  SECTION("by load_waiting()") {
    Waiting waiting({"listed"});
    waiting.catalog.load_waiting(diagnostics);
    CHECK(waiting.catalog.types().size() == 2);
  }
  SECTION("by a program that says nothing of when") {
    const Waiting waiting({"listed"});
    Catalog catalog;
    catalog.load_search_path({}, diagnostics, {waiting.scratch.path});
    CHECK(catalog.types().size() == 2);
  }
  SECTION("by a plugin of the program of the same name") {
    Waiting waiting({"listed"});
    waiting.catalog.add(linked("listed", {"x"}), diagnostics);
    CHECK(diagnostics.text() ==
          "error[B046]: plugin 'listed' is loaded already, from " + (waiting.scratch.path / "listed.so").string());
    diagnostics = {};
  }
  CHECK(diagnostics.text() == "");
  CHECK(Waiting::is_loaded());
}

TEST_CASE("a copy of a plugin that waits is an error that names the first", "[catalog]") {
  Waiting waiting({"listed"});
  fs::copy_file(plugin_at("listed"), waiting.scratch.path / "other.so");
  Diagnostics diagnostics;
  waiting.catalog.load(waiting.scratch.path / "other.so", diagnostics);
  CHECK(diagnostics.text() == (waiting.scratch.path / "other.so").string() +
                                  ": error[B046]: plugin 'listed' is loaded already, from " +
                                  (waiting.scratch.path / "listed.so").string());
  CHECK_FALSE(Waiting::is_loaded());
}

TEST_CASE("a plugin whose list is wrong is refused, type by type", "[catalog]") {
  const std::string more = "plugin 'wrong_list' registers 'rest', which its BINNACLE_TYPES lacks";
  const std::string fewer = "plugin 'wrong_list' lists 'restless' in its BINNACLE_TYPES, and does not register it";
  CHECK(load("wrong_list") == Lines{"wrong_list.so: error[B045]: " + more, "wrong_list.so: error[B045]: " + fewer});

  const std::string refused = "wrong_list.so: warning[B047]: not loaded: " + more + " (and 1 more)\n";
  const std::string lacking = "'wrong_list.so' may contain it, but is not loaded: " + more + " (and 1 more)";
  CHECK(Waiting({"wrong_list"}).want(Role::state_block, "still") ==
        refused + "c.json:3:5: error[B047] /x/type: unknown state block 'still'; " + lacking);
  // Not in its list: looked for in it all the same.
  CHECK(Waiting({"wrong_list"}).want(Role::process_model, "rest") ==
        refused + "c.json:3:5: error[B047] /x/type: unknown process model 'rest'; " + lacking);
}

}  // namespace waiting_plugins_test
