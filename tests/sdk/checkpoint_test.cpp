// SPDX-License-Identifier: Apache-2.0
// --checkpoint and --resume as a user has them: runs that are killed, whenever, and go on.
#include "catch.hpp"

#include <chrono>
#include <csignal>
#include <filesystem>
#include <random>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace checkpoint_test {

using namespace binnacle::test;

namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

#ifdef NDEBUG
constexpr int many_kills = 100;
#else
constexpr int many_kills = 6;
#endif

const std::string quickstart = BINNACLE_TEST_PROJECT "/configs/quickstart.json";

/// With samples under way, a history, a metric of the whole path and a sink.
const Arguments config{
    "run",
    quickstart,
    "--quiet",
    "--set",
    R"(/sources/drive/latency={"uniform": [0, "1.9 s"]})",
    "--set",
    R"(/filters/ins/history="2 s")",
    "--set",
    R"(/evaluate/metrics=["ins/position.segments/translation", "ins/position.segments/rotation"])",
    "--set",
    R"(/sinks/out={"type": "csv_writer", "input": "ins.settled", "path": "out.csv",
                          "fields": {"height": "position.height"}, "columns": {"height": {"unit": "m"}}})",
    "--set",
    R"(/sinks/lines={"type": "stream/json_writer", "input": "ins.settled", "to": "file:lines.jsonl"})"};

Arguments with(Arguments more) {
  more.insert(more.begin(), config.begin(), config.end());
  return more;
}

std::string without_times(const std::string& json) {
  auto summary = nlohmann::json::parse(json);
  summary.erase("wall_s");
  for (auto& filter : summary.at("filters")) filter.erase("filter_s");
  return summary.dump(1);
}

/// The data of a NetCDF file as text, every bit of it, without what names the moment of its creation.
std::string data_of(const Workbench& bench, const std::string& file) {
  const auto dump = binnacle::test::binnacle(bench, {"-p", "9,17", bench.path(file)}, {.program = "/usr/bin/ncdump"});
  REQUIRE(dump.status == 0);
  REQUIRE(dump.out.size() > 10000);
  return std::regex_replace(dump.out.substr(dump.out.find('\n')), std::regex("\n\t\t:(history|created) = [^\n]*"), "");
}

/// All that the run left: it is the same to the byte, times of the machine aside.
std::vector<std::string> left_in(const Workbench& bench) {
  return {without_times(read_file(bench.path("out/summary.json"))), read_file(bench.path("out/ins.csv")),
          read_file(bench.path("out.csv")), read_file(bench.path("lines.jsonl")), data_of(bench, "out/run.nc")};
}

void leaves_the_same(int wanted_kills) {
  const Workbench bench;
  const auto begin = std::chrono::steady_clock::now();
  REQUIRE(binnacle::test::binnacle(bench, with({"--out", "out"})).status == 0);
  const auto whole = std::chrono::steady_clock::now() - begin;
  const auto expected = left_in(bench);
  std::mt19937 random(1);
  int kills = 0, resumptions = 0;
  while (kills < wanted_kills) {
    fs::remove_all(bench.path("out"));
    fs::remove(bench.path("out.csv"));
    for (int attempt = 0;; ++attempt) {
      Arguments options = with({"--out", "out", "--checkpoint", "c@5s"});
      const bool goes_on = fs::exists(bench.path("c"));
      if (goes_on) options.insert(options.end(), {"--resume", "c"});
      Command command(bench, options);
      resumptions += goes_on;
      if (attempt < 4) {
        std::this_thread::sleep_for(whole * std::uniform_real_distribution<double>(0, 1)(random));
        command.signal(SIGKILL);
      }
      const auto outcome = command.wait();
      INFO(outcome.err);
      if (outcome.signal == SIGKILL) {
        ++kills;
        continue;
      }
      REQUIRE(outcome.status == 0);
      break;
    }
    const auto left = left_in(bench);
    CAPTURE(kills);
    for (std::size_t i = 0; i < left.size(); ++i) REQUIRE((left[i] == expected[i]));
    REQUIRE_FALSE(fs::exists(bench.path("c")));
    REQUIRE_FALSE(fs::exists(bench.path("c.records")));
  }
  CHECK(2 * resumptions > kills);
}

}  // namespace

TEST_CASE("killed at six random instants and resumed, a run leaves the same bytes") { leaves_the_same(6); }
TEST_CASE("killed at many random instants and resumed, a run leaves the same bytes") { leaves_the_same(many_kills); }

TEST_CASE("an interrupted run says how it goes on") {
  const Workbench bench;
  Command command(bench, with({"--out", "out", "--checkpoint", "c@20s"}));
  const auto is_under_way = [&] {
    return fs::exists(bench.path("c.records")) && fs::file_size(bench.path("c.records")) > 0;
  };
  while (!is_under_way() && command.is_running()) std::this_thread::yield();
  command.signal(SIGINT);
  const auto outcome = command.wait();
  INFO(outcome.err);
  CHECK(outcome.signal == SIGINT);
  CHECK(outcome.err.find("nothing was written; continue with --resume c") != std::string::npos);
  CHECK_FALSE(fs::exists(bench.path("out.csv")));
  CHECK(binnacle::test::binnacle(bench, with({"--out", "out", "--resume", "c"})).status == 0);
}

TEST_CASE("what cannot be resumed is refused, and why") {
  const Workbench bench;
  {
    Command command(bench, with({"--out", "out", "--checkpoint", "c@1s"}));
    while (!fs::exists(bench.path("c")) && command.is_running()) std::this_thread::yield();
    command.signal(SIGKILL);
    command.wait();
  }
  const auto refused = [&](const Arguments& options, int status, const std::string& why) {
    const auto outcome = binnacle::test::binnacle(bench, with(options));
    INFO(outcome.err);
    CHECK(outcome.status == status);
    CHECK(outcome.err.find(why) != std::string::npos);
  };
  refused({"--resume", "c"}, 3, "it began with --out");
  refused({"--out", "out", "--resume", "c", "--seed", "7"}, 3, "belongs to seed 1, run 0, and this is seed 7, run 0");
  refused({"--out", "out", "--resume", "c", "--set", "/title=x"}, 3, "another config");
  refused({"--out", "out", "--resume", "nothing"}, 2, "there is no checkpoint 'nothing'");
  refused({"--checkpoint", "c@60"}, 2, "the unit is missing; is 60s meant?");
  refused({"--checkpoint", "c@60 m"}, 2, "a length");
  refused({"--checkpoint", "c@0 s"}, 2, "it is not above 0");
  refused({"--checkpoint", "none/c"}, 2, "none/c");
  fs::resize_file(bench.path("c.records"), 0);
  fs::resize_file(bench.path("c"), fs::file_size(bench.path("c")) - 1);
  refused({"--out", "out", "--resume", "c"}, 3, "damaged");
}

}  // namespace checkpoint_test
