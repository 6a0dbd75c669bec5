// SPDX-License-Identifier: Apache-2.0
// The gallery, and new filter: each example runs and holds what its page says, each copy runs, and nothing is overwritten.
#include "catch.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "command.hpp"

using namespace binnacle::test;
namespace fs = std::filesystem;

namespace {

const fs::path gallery = fs::path(BINNACLE_TEST_PROJECT) / "configs/gallery";

/// Errors of each example stay below these, in SI: some two times what a run gives, so that other random numbers pass too.
const std::map<std::string, std::map<std::string, double>> rms_bounds{
    {"attitude-magnetometer", {{"attitude.tilt", 0.002}, {"attitude.down", 0.005}, {"hard_iron.x", 1e-7}}},
    {"battery", {{"cell.charge", 0.01}, {"cell.pair", 0.003}}},
    {"car-wheels",
     {{"position.horizontal", 1.5}, {"position.height", 1.5}, {"attitude.down", 0.005}, {"mounting.z", 0.003}}},
    {"foot-zupt", {{"position.horizontal", 4}, {"position.height", 0.1}, {"attitude.tilt", 0.002}}},
    {"loose-ins-gnss",
     {{"position.horizontal", 1}, {"position.height", 1.2}, {"attitude.tilt", 0.002}, {"attitude.down", 0.01}}},
    {"ship-motion", {{"pitch.angle", 0.015}, {"error.error", 0.008}}},
    {"target-tracking", {{"position.norm", 40}, {"velocity.norm", 5}}},
    {"tight-ins-gnss",
     {{"position.horizontal", 1.5}, {"position.height", 1}, {"attitude.down", 0.01}, {"clock.bias", 1}}},
    {"transfer-alignment", {{"attitude.tilt", 0.001}, {"attitude.down", 0.002}, {"mounting.z", 0.002}}},
    {"underwater-dvl", {{"position.horizontal", 6}, {"position.height", 0.2}, {"attitude.down", 0.015}}},
    {"uwb-indoors", {{"position.horizontal", 0.08}, {"position.height", 0.12}, {"attitude.down", 0.015}}},
};

std::vector<std::string> examples() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(gallery))
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// The only filter of the run's summary.
nlohmann::json summary_of(const Workbench& bench, const std::string& config) {
  const auto outcome = binnacle::test::binnacle(bench, {"run", config, "--json"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto filters = nlohmann::json::parse(outcome.out).at("filters");
  REQUIRE(filters.size() == 1);
  return filters.begin().value();
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

/// Exit status 2 with this in the message, and not a file more or less than before.
std::string refusal(const Workbench& bench, const std::vector<std::string>& arguments) {
  const auto before = names_in(bench.folder());
  const auto outcome = binnacle::test::binnacle(bench, arguments);
  CHECK(outcome.status == 2);
  CHECK(outcome.out.empty());
  CHECK(names_in(bench.folder()) == before);
  return outcome.err;
}

bool begins(const std::string& text, const std::string& with) { return text.rfind(with, 0) == 0; }

}  // namespace

TEST_CASE("each config of the gallery runs, is consistent, and errs by no more than its bounds") {
  const Workbench bench;
  REQUIRE(examples().size() == rms_bounds.size());
  for (const auto& name : examples()) {
    INFO(name);
    const auto filter = summary_of(bench, (gallery / (name + ".json")).string());
    CHECK(filter.at("verdict").at("state") == "ok");
    REQUIRE(rms_bounds.count(name) == 1);
    for (const auto& [error, bound] : rms_bounds.at(name)) {
      INFO(error);
      const double rms = filter.at("reference").at(error).at("rms");
      CHECK(rms < bound);
      CHECK(rms > bound / 50);  // a bound that nothing reaches bounds nothing
    }
    // Of one run, whose errors are correlated in time: a band for what is neither overconfident nor asleep.
    const auto& consistency = filter.at("consistency");
    const auto& all = consistency.contains("state") ? consistency.at("state") : consistency.begin().value();
    const double per_dof = all.at("nees_mean").get<double>() / all.at("dof").get<double>();
    CHECK(per_dof > 0.4);
    CHECK(per_dof < 1.6);
  }
}

TEST_CASE("configs of the gallery are short, begin with what they show, and have a section and a picture") {
  const std::string page = read_file(gallery / "README.md");
  for (const auto& name : examples()) {
    INFO(name);
    const std::string text = read_file(gallery / (name + ".json"));
    CHECK(std::count(text.begin(), text.end(), '\n') <= 60);
    CHECK(begins(text, "{\n  // "));
    CHECK(text.find("// States (") != std::string::npos);
    CHECK(text.find("// Your own data: ") != std::string::npos);
    std::size_t widest = 0;
    for (std::size_t at = 0, end; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
      widest = std::max(widest, end - at);
    CHECK(widest <= 180);
    CHECK(page.find("\n## " + name + "\n") != std::string::npos);
    CHECK(page.find("](" + name + ".svg)") != std::string::npos);
    CHECK(fs::file_size(gallery / (name + ".svg")) <= 40'000);
  }
}

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
  CHECK(begins(
      refusal(bench, {"new", "filter", "x", "--from", "inner/data.json"}),
      "error: 'inner/data.json' needs '../drive', which does not come along; run it where it is, or copy its folder"));
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
