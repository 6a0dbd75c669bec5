// SPDX-License-Identifier: Apache-2.0
// new filter: each copy runs, what it needs comes along, and nothing is overwritten.
#include "catch.hpp"

#include <filesystem>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "gallery.hpp"
#include "refusal.hpp"

namespace new_filter_test {

using namespace binnacle::test;
namespace fs = std::filesystem;

TEST_CASE("new filter copies each example into a folder of one's own, where it runs") {
  const Workbench bench;
  for (const auto& name : examples()) {
    INFO(name);
    fs::create_directory(bench.path(name));
    const auto outcome = binnacle::test::binnacle(bench, {"new", "filter", "my-filter", "--from", name, "--dir", name});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    CHECK(begins(outcome.out, name + "/my-filter.json: a copy of " + name + ", \""));
    CHECK(outcome.out.find("binnacle run " + name + "/my-filter.json --out out") != std::string::npos);
    CHECK(read_file(bench.path(name + "/my-filter.json")) == read_file(gallery / (name + ".json")));
    const auto copy = summary_of(bench, bench.path(name + "/my-filter.json"));
    CHECK(copy.at("verdict").at("state") == "ok");
  }
}

TEST_CASE("new filter copies the loosely coupled one by default, and a name may end in .json") {
  const Workbench bench;
  REQUIRE(binnacle::test::binnacle(bench, {"new", "filter", "my_ins"}).status == 0);
  CHECK(read_file(bench.path("my_ins.json")) == read_file(gallery / "loose-ins-gnss.json"));
  REQUIRE(binnacle::test::binnacle(bench, {"new", "filter", "other.json"}).status == 0);
  CHECK(fs::exists(bench.path("other.json")));
  CHECK_FALSE(fs::exists(bench.path("other.json.json")));

  const auto outcome = binnacle::test::binnacle(bench, {"new", "filter", "soc", "--from", "battery", "--json"});
  REQUIRE(outcome.status == 0);
  const auto reported = nlohmann::json::parse(outcome.out);
  CHECK(reported.at("config") == "soc.json");
  CHECK(reported.at("from") == "battery");
  CHECK(reported.at("files") == nlohmann::json{"soc.json", "battery.csv"});
}

TEST_CASE("new filter takes what a config extends along, and it runs") {
  const Workbench bench;
  const std::string project = BINNACLE_TEST_PROJECT;
  REQUIRE(
      binnacle::test::binnacle(bench, {"new", "filter", "flight", "--from", project + "/configs/ins_gps/straight.json"})
          .status == 0);
  CHECK(fs::exists(bench.path("base.json")));
  CHECK(fs::exists(bench.path("parts.json")));
  CHECK(binnacle::test::binnacle(bench, {"check", "flight.json"}).status == 0);

  fs::create_directories(bench.path("from/parts"));
  bench.write("from/top.json", R"({"extends": "parts/middle.json#/config"})");
  bench.write("from/parts/middle.json",
              R"({"config": {"extends": ["../base.json", "#/other"]}, "other": {"title": "mine"}})");
  bench.write("from/base.json", std::string(good_config));
  for (const char* file : {"fix.csv", "truth.csv"})
    fs::copy_file(bench.path(file), bench.path(std::string("from/") + file));
  fs::create_directory(bench.path("to"));
  REQUIRE(binnacle::test::binnacle(bench, {"new", "filter", "top", "--from", "from/top.json", "--dir", "to"}).status ==
          0);
  CHECK(names_in(bench.path("to")) == std::set<std::string>{"top.json", "parts", "base.json", "fix.csv", "truth.csv"});
  CHECK(binnacle::test::binnacle(bench, {"run", "to/top.json"}).status == 0);
}

TEST_CASE("new filter refuses a config that a copy of its folder's files would not make run") {
  const Workbench bench;
  fs::create_directory(bench.path("inner"));
  bench.write("inner/data.json",
              R"({"vars": {"drive": "../drive"}, "sources": {"s": {"type": "csv", "path": "${drive}/imu.csv"}}})");
  CHECK(begins(refusal(bench, {"new", "filter", "x", "--from", "inner/data.json"}),
               "error: 'inner/data.json' needs '../drive', which is not copied; run the example in its folder, or copy "
               "this folder"));
  bench.write("inner/plugin.json", R"({"plugins": ["build/own.so"]})");
  CHECK(begins(refusal(bench, {"new", "filter", "x", "--from", "inner/plugin.json"}),
               "error: 'inner/plugin.json' needs 'build/own.so'"));
  bench.write("inner/broken.json", "{");
  CHECK(begins(refusal(bench, {"new", "filter", "x", "--from", "inner/broken.json"}),
               "error: 'inner/broken.json' is not JSON"));
  bench.write("inner/gone.json", R"({"extends": "nowhere.json"})");
  CHECK(begins(refusal(bench, {"new", "filter", "x", "--from", "inner/gone.json"}), "error: "));
  bench.write("inner/x.json", "{}");
  bench.write("inner/clash.json", R"({"extends": "x.json"})");
  CHECK(begins(refusal(bench, {"new", "filter", "x", "--from", "inner/clash.json"}),
               "error: 'x.json' is the name of a file that"));
}

TEST_CASE("new filter leaves what exists as it is") {
  const Workbench bench;
  bench.write("my.json", "mine");
  CHECK(begins(refusal(bench, {"new", "filter", "my"}), "error: 'my.json' exists already; nothing was written"));
  CHECK(read_file(bench.path("my.json")) == "mine");
  bench.write("battery.csv", "mine too");
  CHECK(begins(refusal(bench, {"new", "filter", "soc", "--from", "battery"}),
               "error: 'battery.csv' exists already; nothing was written"));
  CHECK(read_file(bench.path("battery.csv")) == "mine too");
  fs::remove(bench.path("battery.csv"));

  fs::create_directories(bench.path("from/parts"));
  bench.write("from/top.json", R"({"extends": ["parts/middle.json", "base.json"]})");
  bench.write("from/parts/middle.json", "{}");
  bench.write("from/base.json", "{}");
  bench.write("base.json", "mine as well");
  CHECK(begins(refusal(bench, {"new", "filter", "top", "--from", "from/top.json"}),
               "error: 'base.json' exists already; nothing was written"));

  // What an earlier copy left is the same, and stays.
  REQUIRE(binnacle::test::binnacle(bench, {"new", "filter", "one", "--from", "battery"}).status == 0);
  CHECK(binnacle::test::binnacle(bench, {"new", "filter", "two", "--from", "battery"}).status == 0);
}

TEST_CASE("new filter names the example that was meant, and all that there are") {
  const Workbench bench;
  for (const auto& [typed, meant] : std::map<std::string, std::string>{{"loose-ins-gns", "loose-ins-gnss"},
                                                                       {"uwb", "uwb-indoors"},
                                                                       {"DVL", "underwater-dvl"},
                                                                       {"gnss-tightly", "tight-ins-gnss"}}) {
    const std::string message = refusal(bench, {"new", "filter", "x", "--from", typed});
    CHECK(begins(message, "error: there is no example '" + typed + "'; did you mean '" + meant + "'?\n"));
    for (const auto& name : examples()) CHECK(message.find("\n  " + name + " ") != std::string::npos);
  }
  CHECK(begins(refusal(bench, {"new", "filter", "x", "--from", "zzz"}), "error: there is no example 'zzz'\n"));

  const auto list = binnacle::test::binnacle(bench, {"new", "filter", "--list"});
  CHECK(list.status == 0);
  for (const auto& name : examples()) CHECK(list.out.find("  " + name + " ") != std::string::npos);
  const auto reported =
      nlohmann::json::parse(binnacle::test::binnacle(bench, {"new", "filter", "--list", "--json"}).out);
  CHECK(reported.at("examples").size() == examples().size());
}

TEST_CASE("new filter refuses names, folders and options that it has no use for") {
  const Workbench bench;
  CHECK(begins(refusal(bench, {"new", "filter", "a/b"}), "error: 'a/b' is not a name; --dir gives the folder"));
  for (const char* name : {".json", "my filter", "x;y", "\xc3\xa4"})
    CHECK(begins(refusal(bench, {"new", "filter", name}),
                 "error: '" + std::string(name) + "' is not a name for a config (a-z, A-Z, 0-9, _, -)"));
  CHECK(begins(refusal(bench, {"new", "filter", "x", "--dir", "nowhere"}), "error: there is no folder 'nowhere'"));
  CHECK(begins(refusal(bench, {"new", "filter"}), "error: NAME is missing: binnacle new filter NAME"));
  CHECK(begins(refusal(bench, {"new", "filter", "x", "--kind", "source"}), "error: 'new filter' has no option --kind"));
  CHECK(
      begins(refusal(bench, {"new", "plugin", "x", "--from", "battery"}), "error: 'new plugin' has no option --from"));
  CHECK(begins(refusal(bench, {"new", "fliter", "x"}),
               "error: there is nothing new called 'fliter'; did you mean 'filter'?"));
}

}  // namespace new_filter_test
