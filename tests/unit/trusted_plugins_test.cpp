// SPDX-License-Identifier: Apache-2.0
// Which plugins are loaded of those that could be: who else may exchange them, who named them, and that what was checked
// is what is loaded.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <fstream>
#include <thread>

#include "../skip.hpp"
#include "loader_work.hpp"

namespace trusted_plugins_test {

using namespace loader_work;

namespace {

/// What is said of a plugin that a config names, `c.json` of another folder; "" where it is loaded.
std::string named(const fs::path& path, const Origin& origin = {"c.json", 2, 14}) {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load_search_path({{path, origin, "/plugins/0"}}, diagnostics, {"/nowhere/at/all"});
  const bool is_loaded = catalog.find(Role::state_block, "good/still") != nullptr;
  CHECK(is_loaded == diagnostics.text().empty());
  return diagnostics.text();
}

std::string loaded(const fs::path& file) {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(file, diagnostics);
  CHECK(catalog.types().empty() == diagnostics.has_errors());
  return diagnostics.text();
}

std::string refusal(const fs::path& path) {
  return "c.json:2:14: error[B048] /plugins/0: '" + path.string() +
         "' is not loaded: a config may only name plugins that lie in a trusted folder or were built here; "
         "--allow-plugins loads it";
}

/// As binnacle_add_plugin() does after linking.
void note_as_built(const fs::path& file) {
  const std::string line = "stat -c '%i %.9Z' '" + file.string() + "' > '" + file.string() + ".built'";
  REQUIRE(std::system(line.c_str()) == 0);
}

fs::path good_in(const fs::path& folder) {
  fs::create_directories(folder);
  fs::copy_file(plugin_at("good"), folder / "good.so");
  return folder / "good.so";
}

/// Whether the tests may give files away; where not, the test counts as skipped.
bool may_give_away() {
  if (::geteuid() == 0) return true;
  binnacle::test::skip("only root can give files to others");
  return false;
}

}  // namespace

TEST_CASE("a config may not name a plugin outside the trusted folders", "[catalog]") {
  const Scratch scratch;
  const fs::path file = good_in(scratch.path / "elsewhere");
  CHECK(named(file) == refusal(file));
  CHECK(named(file.parent_path()) == refusal(file.parent_path()));
  SECTION("unless the folder is one of the environment's, whatever the way to it") {
    const Variable folders("BINNACLE_PLUGIN_PATH", file.parent_path().string());
    CHECK(named(file) == "");
    CHECK(named(file.parent_path()) == "");
    CHECK(named(scratch.path / "elsewhere" / ".." / "elsewhere" / "good.so") == "");
  }
  SECTION("nor one beside a trusted folder by '..' or a link") {
    const fs::path trusted = scratch.path / "trusted";
    fs::create_directory(trusted);
    fs::create_symlink(file, scratch.path / "link.so");
    const Variable folders("BINNACLE_PLUGIN_PATH", trusted.string());
    CHECK(named(trusted / ".." / "elsewhere" / "good.so") == refusal(trusted / ".." / "elsewhere" / "good.so"));
    CHECK(named(scratch.path / "link.so") == refusal(scratch.path / "link.so"));
    CHECK(named(scratch.path) == refusal(scratch.path));
  }
  SECTION("unless the user allows it, or named it on the command line") {
    CHECK(named(file, {"--set", 0, 0}) == "");
    const Variable allowed("BINNACLE_ALLOW_PLUGINS", "1");
    CHECK(named(file) == "");
  }
  SECTION("what is wrong with it anyway is said first") {
    std::ofstream(scratch.path / "fix.csv") << "t,place\n0,1\n";
    CHECK(named(scratch.path / "fix.csv").find("fix.csv: error[B041]: not a plugin for this program") !=
          std::string::npos);
  }
}

TEST_CASE("a config may name a plugin that was built here and not touched since", "[catalog]") {
  const Scratch scratch;
  const fs::path file = good_in(scratch.path / "build");
  note_as_built(file);
  CHECK(named(file) == "");
  CHECK(named(file.parent_path()) == "");
  SECTION("not one that was changed") {
    fs::last_write_time(file, fs::file_time_type::clock::now());
    CHECK(named(file) == refusal(file));
  }
  SECTION("not a copy, even with its note") {
    fs::copy(scratch.path / "build", scratch.path / "copy");
    CHECK(named(scratch.path / "copy" / "good.so") == refusal(scratch.path / "copy" / "good.so"));
  }
  SECTION("not an archive's") {
    const std::string at = "cd '" + scratch.path.string() + "' && ";
    REQUIRE(std::system((at + "tar -cf a.tar build && rm -r build && tar -xpf a.tar").c_str()) == 0);
    REQUIRE(fs::exists(file.string() + ".built"));
    CHECK(named(file) == refusal(file));
  }
  SECTION("not a folder with another in it") {
    fs::copy_file(plugin_at("second"), scratch.path / "build" / "second.so");
    CHECK(named(file.parent_path()) == refusal(file.parent_path()));
  }
}

TEST_CASE("a plugin that others could exchange is refused", "[catalog]") {
  const Scratch scratch;
  const fs::path outer = scratch.path / "open", file = good_in(outer / "inner");
  CHECK(loaded(file) == "");
  SECTION("since everybody may write its folder, or one above") {
    for (const fs::path& open : {outer / "inner", outer}) {
      fs::permissions(open, fs::perms::others_write, fs::perm_options::add);
      CHECK(loaded(file) == file.string() + ": error[B044]: the plugin's folder '" + open.string() +
                                "' is world-writable, so it is not loaded; chmod o-w it");
      ::chmod(open.c_str(), 01777);  // sticky: nobody can take away what is another's
      CHECK(loaded(file) == "");
      ::chmod(open.c_str(), 0755);
    }
  }
  SECTION("since a group may write the file or its folder") {
    if (!may_give_away()) return;
    for (const fs::path& open : {file, file.parent_path()}) {
      REQUIRE(::chown(open.c_str(), static_cast<uid_t>(-1), 54321) == 0);
      CHECK(loaded(file) == "");
      fs::permissions(open, fs::perms::group_write, fs::perm_options::add);
      CHECK(loaded(file) == file.string() + ": error[B044]: " +
                                (open == file ? "the plugin file" : "the plugin's folder '" + open.string() + "'") +
                                " may be written by a group, so it is not loaded; chmod g-w it");
      fs::permissions(open, fs::perms::group_write, fs::perm_options::remove);
    }
  }
  SECTION("since it is somebody else's, or its folder is") {
    if (!may_give_away()) return;
    for (const fs::path& given : {file, file.parent_path()}) {
      REQUIRE(::chown(given.c_str(), 54321, static_cast<gid_t>(-1)) == 0);
      CHECK(loaded(file).find(
                " belongs to user 54321, who is neither root, nor you, nor the owner of this program, so it "
                "is not loaded; copy it, or chown it") != std::string::npos);
      REQUIRE(::chown(given.c_str(), ::geteuid(), static_cast<gid_t>(-1)) == 0);
      CHECK(loaded(file) == "");
    }
  }
}

TEST_CASE("a searched folder that everybody may write brings nothing, and says why", "[catalog]") {
  const Scratch scratch;
  const fs::path file = good_in(scratch.path / "open");
  fs::permissions(file.parent_path(), fs::perms::others_write, fs::perm_options::add);
  const Variable folders("BINNACLE_PLUGIN_PATH", file.parent_path().string());
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load_search_path({}, diagnostics, {"/nowhere/at/all"});
  CHECK(catalog.plugins().empty());
  CHECK(diagnostics.text() == file.string() + ": warning[B047]: not loaded: the plugin's folder '" +
                                  file.parent_path().string() +
                                  "' is world-writable, so it is not loaded; chmod o-w it");
}

TEST_CASE("a relative folder of BINNACLE_PLUGIN_PATH is not searched, and the whole path is shown", "[catalog]") {
  const Scratch scratch;
  good_in(scratch.path);
  fs::create_directory(scratch.path / "inner");
  const fs::path before = fs::current_path();
  const std::vector<std::pair<fs::path, std::string>> cases = {{scratch.path, "."},
                                                               {scratch.path / "inner", ".."},
                                                               {scratch.path / "inner",
                                                                "../../" + scratch.path.filename().string()}};
  for (const auto& [at, searched] : cases) {
    fs::current_path(at);
    const Variable folders("BINNACLE_PLUGIN_PATH", searched);
    Catalog catalog;
    Diagnostics diagnostics;
    catalog.load_search_path({}, diagnostics, {"/nowhere/at/all"});
    fs::current_path(before);
    CHECK(catalog.plugins().empty());
    CHECK(diagnostics.text().find("warning[B040]: BINNACLE_PLUGIN_PATH: '" + searched +
                                  "' is not searched, because its meaning depends on the working folder; write '" +
                                  scratch.path.string()) == 0);
  }
}

TEST_CASE("a file that is exchanged while it is loaded never runs unchecked: 300 times", "[catalog]") {
  ::unsetenv("BINNACLE_TEST_CODE_RAN");
  const Scratch scratch;
  const fs::path file = scratch.path / "plugin.so", spare = scratch.path / "spare";
  fs::copy_file(plugin_at("good"), file);
  fs::copy_file(plugin_at("wrong_guard"), spare);
  std::atomic<bool> is_over{false};
  std::atomic<long> exchanges{0};
  std::thread exchanger([&] {
    while (!is_over) {
      ::renameat2(AT_FDCWD, file.c_str(), AT_FDCWD, spare.c_str(), RENAME_EXCHANGE);
      ++exchanges;
    }
  });
  while (exchanges < 10) std::this_thread::yield();
  int loads = 0, wins = 0;
  for (int i = 0; i < 300 || (loads == 0 && i < 30000); ++i) {
    Catalog catalog;
    Diagnostics diagnostics;
    catalog.load(file, diagnostics);
    loads += diagnostics.has_errors() ? 0 : 1;
    wins += ::getenv("BINNACLE_TEST_CODE_RAN") != nullptr;
    ::unsetenv("BINNACLE_TEST_CODE_RAN");
  }
  is_over = true;
  exchanger.join();
  CHECK(wins == 0);
  INFO(loads << " loads, " << exchanges << " exchanges");
  CHECK(loads > 0);
  CHECK(exchanges > 300);
}

TEST_CASE("a file that takes the place of one that was loaded is loaded itself", "[catalog]") {
  const Scratch scratch;
  const fs::path file = scratch.path / "plugin.so";
  for (int i = 0; i < 3; ++i)
    for (const char* name : {"good", "second", "only_warned"}) {
      fs::remove(file);
      fs::copy_file(plugin_at(name), file);
      Catalog catalog;
      Diagnostics diagnostics;
      catalog.load(file, diagnostics);
      REQUIRE(catalog.plugins().size() == 1);
      CHECK(catalog.plugins()[0].name == name);
      CHECK(catalog.types().front()->full_name().find(std::string(name) + "/") == 0);
    }
}

TEST_CASE("a plugin that is exchanged while it waits is not loaded under the other's name", "[catalog]") {
  const Scratch scratch;
  const fs::path file = scratch.path / "listed.so";
  fs::copy_file(plugin_at("listed"), file);
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load_search_path({}, diagnostics, {scratch.path}, Catalog::Loading::when_wanted);
  REQUIRE(catalog.plugins().size() == 1);
  fs::remove(file);
  fs::copy_file(plugin_at("good"), file);
  catalog.load_waiting(diagnostics);
  CHECK(catalog.plugins().empty());
  CHECK(diagnostics.text().find("not loaded: the plugin was exchanged while it was being loaded; start again") !=
        std::string::npos);
}

TEST_CASE("a FIFO in a plugin folder holds nobody up", "[catalog]") {
  const Scratch scratch;
  REQUIRE(::mkfifo((scratch.path / "pipe.so").c_str(), 0600) == 0);
  CHECK(loaded(scratch.path / "pipe.so") ==
        (scratch.path / "pipe.so").string() + ": error[B040]: the plugin is not a file");
}

TEST_CASE("a plugin that looks for libraries beside itself finds them", "[catalog]") {
  CHECK(load("looks_beside") == Lines{});
}

}  // namespace trusted_plugins_test
