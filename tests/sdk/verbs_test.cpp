// SPDX-License-Identifier: Apache-2.0
// The other verbs: what they print can be read by people and parsed by programs.
#include "catch.hpp"

#include <filesystem>
#include <fstream>
#include <set>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace verbs_test {

using namespace binnacle::test;
using nlohmann::json;

namespace {

json parsed(const Workbench& bench, const std::vector<std::string>& arguments) {
  const auto outcome = binnacle::test::binnacle(bench, arguments);
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(outcome.out);
}

void is_usage_error(const Workbench& bench, const std::vector<std::string>& arguments, const std::string& first_line) {
  const auto outcome = binnacle::test::binnacle(bench, arguments);
  CHECK(outcome.status == 2);
  CHECK(outcome.out.empty());
  CHECK(outcome.err.substr(0, outcome.err.find('\n')) == first_line);
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a wrong command line is exit status 2, with what was meant") {
  const Workbench bench;
  is_usage_error(bench, {"rnu", "good.json"}, "error: unknown verb 'rnu'; did you mean 'run'?");
  is_usage_error(bench, {"smooth", "good.json"}, "error: unknown verb 'smooth'; did you mean 'run CONFIG --smooth'?");
  is_usage_error(bench, {"run", "good.json", "--sumary", "x"},
                 "error: unknown option '--sumary'; did you mean '--summary'?");
  is_usage_error(bench, {"run", "--sumary=x"}, "error: unknown option '--sumary'; did you mean '--summary'?");
  is_usage_error(bench, {"run"}, "error: CONFIG is required");
  is_usage_error(bench, {"explain", "good.json", "more"}, "error: 'more' is one argument too many");
  is_usage_error(bench, {"run", "good.json", "--var", "data"}, "error: --var takes NAME=PATH; found 'data'");
  is_usage_error(bench, {"describe", "vectro"}, "error: there is no component type 'vectro'; did you mean 'vector'?");
  is_usage_error(bench, {"help", "rnu"}, "error: unknown verb 'rnu'; did you mean 'run'?");
  const auto nothing = binnacle::test::binnacle(bench, {});
  CHECK(nothing.status == 2);
  CHECK(has(nothing.err, "explain"));
}

TEST_CASE("a module that was not built is named, with what builds it, and the command does the rest without it") {
  const Workbench bench;
  const std::string bin = bench.path("bin");
  std::filesystem::create_directory(bin);
  std::filesystem::copy(BINNACLE_TEST_COMMAND, bin);
  const Start alone{{}, {{"BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS}}, bin + "/binnacle"};
  const auto lacks = [&](const std::vector<std::string>& words, const std::string& what, const std::string& module) {
    const auto outcome = binnacle::test::binnacle(bench, words, alone);
    CHECK(outcome.status == 2);
    CHECK(outcome.out.empty());
    CHECK(outcome.err == "error: this build has no " + what + " (" + bin + "/" + module +
                             " is missing); in a clone, sdk/run --all builds it\n");
  };
  const auto all = binnacle::test::binnacle(bench, {"--help"}, alone);
  CHECK(all.status == 0);
  CHECK(all.out == binnacle::test::binnacle(bench, {"--help"}).out);
  for (const std::string verb : {"study", "covariance", "tune", "observe", "allan"})
    lacks({verb, "good.json"}, "'" + verb + "'", "binnacle-study");
  for (const std::string verb : {"explain", "list", "describe", "create", "schema", "graph", "new"})
    lacks({verb, "--help"}, "'" + verb + "'", "binnacle-describe");
  for (const std::string verb : {"report", "export"}) lacks({verb, "out"}, "'" + verb + "'", "binnacle-report");
  lacks({"help", "inspect"}, "'inspect'", "binnacle-inspect");
  lacks({"conform", "plugin.so"}, "'conform'", "binnacle-conform");
  CHECK(binnacle::test::binnacle(bench, {"run", "good.json", "--quiet"}, alone).status == 0);
  CHECK(binnacle::test::binnacle(bench, {"check", "good.json"}, alone).status == 0);
  bench.spoil("\"sources\"", "\"study\": { \"runs\": 2, \"metrics\": [] }, \"sources\"");
  lacks({"check", "good.json", "bad.json"}, "'check' of a config with \"study\"", "binnacle-study");
  CHECK(binnacle::test::binnacle(bench, {"rnu"}, alone).err == binnacle::test::binnacle(bench, {"rnu"}).err);

  std::ofstream(bin + "/binnacle-inspect") << "no program";
  const auto outcome = binnacle::test::binnacle(bench, {"inspect", "fix.csv"}, alone);
  CHECK(outcome.status == 2);
  CHECK(outcome.err == "error: " + bin + "/binnacle-inspect cannot be run, which has 'inspect': Permission denied\n");
}

TEST_CASE("a module takes its own verbs alone") {
  const Workbench bench;
  const std::string folder = std::filesystem::path(BINNACLE_TEST_COMMAND).parent_path().string();
  const Start module{{}, {}, folder + "/binnacle-report"};
  const auto outcome = binnacle::test::binnacle(bench, {"run", "good.json"}, module);
  CHECK(outcome.status == 2);
  CHECK(outcome.err ==
        "error: binnacle-report is a part of the binnacle command, for 'binnacle report', 'binnacle export', 'binnacle "
        "verdict'\n");
  CHECK(binnacle::test::binnacle(bench, {"export", "--help"}, module).out ==
        binnacle::test::binnacle(bench, {"export", "--help"}).out);
}

TEST_CASE("the usual words for the version and for help are understood") {
  const Workbench bench;
  const auto out = [&](const std::vector<std::string>& words) {
    const auto outcome = binnacle::test::binnacle(bench, words);
    CHECK(outcome.status == 0);
    return outcome.out;
  };
  CHECK(out({"--version"}) == out({"version"}));
  CHECK(out({"-V"}) == out({"version"}));
  CHECK(out({"help"}) == out({"--help"}));
  CHECK(out({"help", "allan"}) == out({"allan", "--help"}));
}

TEST_CASE("a config of the README that is not here, but comes with the command, is named") {
  const Workbench bench;
  const auto found = binnacle::test::binnacle(bench, {"run", "configs/quickstart.json"});
  CHECK(found.status == 3);
  CHECK(has(found.err, "note: it comes with this command as "));
  CHECK(has(found.err, "/share/binnacle/configs/quickstart.json\n"));
  CHECK_FALSE(has(binnacle::test::binnacle(bench, {"run", "configs/nothing.json"}).err, "note:"));
}

TEST_CASE("data in place of a config: the verb that takes data is named") {
  const Workbench bench;
  bench.write("imu.csv", "t,wx\n0,1\n");
  bench.write("broken.json", "t");
  const auto data = binnacle::test::binnacle(bench, {"run", "imu.csv"});
  INFO(data.err);
  CHECK(data.status == 3);
  CHECK(has(data.err, "imu.csv:1:1: error[B001]"));
  CHECK(has(data.err, "'binnacle inspect imu.csv --write my.json'"));
  CHECK_FALSE(has(binnacle::test::binnacle(bench, {"run", "broken.json"}).err, "inspect"));
}

TEST_CASE("--help is no error, and names only what there is") {
  const Workbench bench;
  const auto help = binnacle::test::binnacle(bench, {"--help"});
  CHECK(help.status == 0);
  for (const char* verb : {"run", "tune", "check", "explain", "list", "describe", "create", "schema", "graph", "report",
                           "export", "new", "version"}) {
    INFO(verb);
    CHECK(has(help.out, std::string("\n  ") + verb));
    CHECK(binnacle::test::binnacle(bench, {verb, "--help"}).status == 0);
  }
}

TEST_CASE("list shows every component type") {
  const Workbench bench;
  const auto types = parsed(bench, {"list", "--json"});
  std::set<std::string> names;
  for (const auto& type : types) {
    names.insert(type.at("name"));
    CHECK_FALSE(type.at("summary").get<std::string>().empty());
  }
  for (const char* name : {"core/vector", "core/random_walk", "core/linear_measurement", "csv/csv"})
    CHECK(names.contains(name));
  for (const auto& type : parsed(bench, {"list", "block", "--json"})) CHECK(type.at("role") == "state block");
  CHECK(has(binnacle::test::binnacle(bench, {"list"}).out, "process model\n"));
  CHECK(has(binnacle::test::binnacle(bench, {"list", "--plugins"}).out, "core.so\n"));
}

TEST_CASE("every listed type can be described, and created") {
  const Workbench bench;
  for (const auto& type : parsed(bench, {"list", "--json"})) {
    const std::string name = type.at("name");
    INFO(name);
    CHECK(parsed(bench, {"describe", name, "--json"}).at("name") == name);
    CHECK(has(binnacle::test::binnacle(bench, {"describe", name}).out, name + ": "));
    CHECK(parsed(bench, {"create", name, "--json"}).at("binnacle") == 1);
  }
}

TEST_CASE("explain shows the layout of the state and the channels") {
  const Workbench bench;
  const auto text = binnacle::test::binnacle(bench, {"explain", "good.json"}).out;
  for (const char* part :
       {"FILTER walk: 1 row", "place.x", "advanced by wander", "estimated",
        "subscribers: /filters/walk/measurements/seen", "gate 0.999 (NIS <= 10.83)", "Unused channels: none"}) {
    INFO(part);
    CHECK(has(text, part));
  }
  CHECK(parsed(bench, {"explain", "good.json", "--json"}).at("filters").at(0).at("dof") == 1);
}

TEST_CASE("graph is DOT that Graphviz draws") {
  const Workbench bench;
  const auto dot = binnacle::test::binnacle(bench, {"graph", "good.json"}).out;
  CHECK(has(dot, "\"/sources/fix\" -> \"/filters/walk/measurements/seen\""));
  CHECK(has(dot, "\"/filters/walk/process/wander\" -> \"/filters/walk/blocks/place\""));
  const auto drawn = binnacle::test::binnacle(bench, {"graph", "good.json", "--svg", "graph.svg"});
  INFO(drawn.err);
  REQUIRE(drawn.status == 0);
  CHECK(drawn.err.empty());
  CHECK(has(read_file(bench.path("graph.svg")), "</svg>"));
}

TEST_CASE("names with quotes and slashes are drawn and recorded too") {
  const Workbench bench;
  bench.spoil("\"walk\": {", "\"a/b \\\"c\\\"\": {");
  const std::string without_reference = "/reference=[]";
  CHECK(
      binnacle::test::binnacle(bench, {"graph", "bad.json", "--set", without_reference, "--svg", "graph.svg"}).status ==
      0);
  REQUIRE(binnacle::test::binnacle(bench, {"run", "bad.json", "--set", without_reference, "--out", "out"}).status == 0);
  CHECK(std::filesystem::exists(bench.path("out/a%2Fb %22c%22.csv")));
}

TEST_CASE("version shows the guard") {
  const Workbench bench;
  const auto version = parsed(bench, {"version", "--json"});
  CHECK_FALSE(version.at("version").get<std::string>().empty());
  CHECK(version.at("guard").contains("API"));
  CHECK(has(binnacle::test::binnacle(bench, {"version"}).out, "binnacle " + version.at("version").get<std::string>()));
}

}  // namespace verbs_test
