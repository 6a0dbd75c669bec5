// SPDX-License-Identifier: Apache-2.0
// binnacle run: the summary, the records, and that nothing half-written is ever seen.
#include "catch.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <thread>

#include <fcntl.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "csv_columns.hpp"
#include "results/results.hpp"

namespace run_test {

using namespace binnacle::test;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

Outcome run(const Workbench& bench, std::vector<std::string> options) {
  options.insert(options.begin(), {"run", "good.json"});
  return binnacle::test::binnacle(bench, options);
}

/// The same filter by hand: estimate and sigma after each fix.
struct Estimate {
  double x, sigma;
};
std::vector<Estimate> kalman() {
  std::vector<Estimate> estimates;
  double x = 0, p = 1;
  for (const double z : {0.1, 0.2, 0.15, 0.3, 0.25}) {
    if (!estimates.empty()) p += 0.1 * 0.1;
    const double gain = p / (p + 0.1 * 0.1);
    x += gain * (z - x);
    p *= 1 - gain;
    estimates.push_back({x, std::sqrt(p)});
  }
  return estimates;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

TEST_CASE("the --summary file holds the errors, the windows and what became of every sample") {
  const Workbench bench;
  const auto outcome = run(bench, {"--summary", "summary.json"});
  REQUIRE(outcome.status == 0);
  CHECK(outcome.err.empty());
  const auto summary = json::parse(read_file(bench.path("summary.json")));
  const auto& filter = summary.at("filters").at("walk");
  const auto expected = kalman();
  const double e1 = 0.2 - expected[1].x, e2 = 0.2 - expected[2].x, e4 = 0.3 - expected[4].x;

  const auto& error = filter.at("reference").at("place.x");
  CHECK(std::abs(error.at("rms").get<double>() - std::sqrt((e1 * e1 + e2 * e2 + e4 * e4) / 3)) < 1e-12);
  CHECK(std::abs(error.at("max").get<double>() - std::max({std::abs(e1), std::abs(e2), std::abs(e4)})) < 1e-12);
  CHECK(std::abs(error.at("final").get<double>() - e4) < 1e-12);
  CHECK(error.at("unit") == "m");
  CHECK(std::abs(filter.at("windows").at("late").at("place.x").at("final").get<double>() - e4) < 1e-12);

  const auto& seen = filter.at("measurements").at("seen");
  CHECK(seen.at("offered") == 5);
  CHECK(seen.at("accepted") == 5);
  for (const char* outcome_name : {"gated", "late", "unsupported", "invalid", "rejected", "withheld"})
    CHECK(seen.at(outcome_name) == 0);
  CHECK(seen.at("dof") == 1);
  CHECK(filter.at("steps") == 4);
  CHECK(summary.at("wall_s").get<double>() > 0);
}

TEST_CASE("the summary is printed as tables, or as JSON, or not") {
  const Workbench bench;
  const auto text = run(bench, {}).out;
  for (const char* part : {"A place that wanders\n", "walk: 0.000 s to 4.000 s, 4 steps", "place.x", "late", "seen"})
    CHECK(text.find(part) != std::string::npos);
  CHECK(json::parse(run(bench, {"--json"}).out).at("filters").contains("walk"));
  CHECK(run(bench, {"--quiet"}).out.empty());
}

TEST_CASE("run --out records every output with its sigma, units in the header, exact numbers in run.nc") {
  const Workbench bench;
  REQUIRE(run(bench, {"--out", "new/out"}).status == 0);
  CHECK(names_in(bench.path("new/out")) ==
        std::vector<std::string>{"config.json", "report.html", "run.nc", "summary.json", "walk.csv"});

  std::istringstream lines(read_file(bench.path("new/out/walk.csv")));
  std::string line;
  std::getline(lines, line);
  CHECK(line == "t[s],place.x[m],place.x.sigma[m]");
  const auto expected = kalman();
  for (std::size_t i = 0; i < expected.size(); ++i) {
    REQUIRE(std::getline(lines, line));
    double t = 0, x = 0, sigma = 0;
    REQUIRE(std::sscanf(line.c_str(), "%lf,%lf,%lf", &t, &x, &sigma) == 3);
    CHECK(t == static_cast<double>(i));
    CHECK(is_as_stated("place.x[m]", expected[i].x, x));
    CHECK(is_as_stated("place.x.sigma[m]", expected[i].sigma, sigma));
  }
  CHECK_FALSE(std::getline(lines, line));
  const auto recorded = binnacle::results::read(bench.path("new/out")).run->filters.at(0);
  REQUIRE(recorded.t.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CHECK(std::abs(recorded.estimates.at(0).values[i] - expected[i].x) < 1e-12);
    CHECK(std::abs(recorded.estimates.at(0).sigma[i] - expected[i].sigma) < 1e-12);
  }
  CHECK(json::parse(read_file(bench.path("new/out/config.json"))).at("title") == "A place that wanders");
  CHECK(json::parse(read_file(bench.path("new/out/summary.json"))).contains("filters"));
}

TEST_CASE("recorded times are exact to the nanosecond") {
  const Workbench bench;
  bench.write("fix.csv", "t,place\n1600000000.123456789,0.1\n1600000001.000000001,0.2\n");
  REQUIRE(run(bench, {"--out", "out"}).status == 0);
  const auto text = read_file(bench.path("out/walk.csv"));
  CHECK(text.find("\n1600000000.123456789,") != std::string::npos);
  CHECK(text.find("\n1600000001.000000001,") != std::string::npos);
}

TEST_CASE("options --set and --var change a config from outside") {
  const Workbench bench;
  const auto config_of = [&](const std::vector<std::string>& options) {
    auto all = options;
    all.insert(all.end(), {"--out", "out"});
    REQUIRE(run(bench, all).status == 0);
    return json::parse(read_file(bench.path("out/config.json")));
  };
  CHECK(config_of({"--set", "/title=Another", "--set", "/filters/walk/blocks/place/sigma=2"})
            .at("/filters/walk/blocks/place/sigma"_json_pointer) == 2);
  CHECK(config_of({"--set=/title=\"in quotes\""}).at("title") == "in quotes");

  fs::create_directory(bench.path("elsewhere"));
  fs::rename(bench.path("fix.csv"), bench.path("elsewhere/fix.csv"));
  bench.spoil("\"fix.csv\"", "\"${data}/fix.csv\"");
  CHECK(binnacle::test::binnacle(bench, {"run", "bad.json", "--var", "data=elsewhere"}).status == 0);
}

TEST_CASE("a place that cannot be written is reported before the run, exit status 2") {
  const Workbench bench;
  const auto is_reported = [&](const std::vector<std::string>& options, const std::string& message) {
    const auto outcome = run(bench, options);
    CHECK(outcome.err == "error: " + message + "\n");
    CHECK(outcome.status == 2);
    CHECK(outcome.out.empty());
  };
  const auto before = names_in(bench.folder());
  is_reported({"--summary", "no/folder.json"}, "cannot write 'no/folder.json': No such file or directory");
  is_reported({"--summary", "."}, "cannot write '.': it is a folder");
  is_reported({"--out", "fix.csv/out"}, "cannot make the folder 'fix.csv/out': Not a directory");
  is_reported({"--out", "fix.csv"}, "cannot make the folder 'fix.csv': Not a directory");
  is_reported({"--out", "made", "--summary", "no/folder.json"},
              "cannot write 'no/folder.json': No such file or directory");
  CHECK(names_in(bench.folder()) == before);
}

TEST_CASE("a device is written to, not replaced, and a full one is exit status 5") {
  const Workbench bench;
  const auto outcome = run(bench, {"--quiet", "--summary", "/dev/stdout"});
  CHECK(outcome.status == 0);
  const auto full = run(bench, {"--quiet", "--summary", "/dev/full"});
  CHECK(full.err ==
        "error: '/dev/full' could not be written: No space left on device; make room there, or write elsewhere\n");
  CHECK(full.status == 5);
  CHECK(fs::is_character_file("/dev/full"));
}

TEST_CASE("data that fail halfway leave nothing behind") {
  const Workbench bench;
  bench.write("fix.csv", "t,place\n0,1\n1,nan\n");
  const auto before = names_in(bench.folder());
  CHECK(run(bench, {"--out", "out/deep", "--summary", "summary.json"}).status == 5);
  CHECK(names_in(bench.folder()) == before);
}

TEST_CASE("a filter that breaks is exit status 1, and its record and summary are kept") {
  const Workbench bench;
  bench.spoil("0.1 m/sqrt(s)", "1e200 m/sqrt(s)");
  const auto outcome = binnacle::test::binnacle(bench, {"run", "bad.json", "--out", "out"});
  CHECK(outcome.status == 1);
  CHECK(outcome.err ==
        "bad.json:9:5: error[B080] /filters/walk: filter 'walk' broke: plugin 'core', component 'random_walk' "
        "(/filters/walk/process/wander): propagate at 1 s gave 'place.x' the process noise inf, which is not a "
        "variance\n1 error\n");
  CHECK(json::parse(read_file(bench.path("out/summary.json"))).at("filters").at("walk").contains("broken"));
  CHECK(fs::exists(bench.path("out/walk.csv")));
}

TEST_CASE("a filter that never starts is exit status 1") {
  const Workbench bench;
  bench.write("truth.csv", "t,place\n1,-1\n2,-1\n");
  bench.spoil(R"~("init": { "x": "0 m" })~", R"~("init": { "channel": "truth" })~");
  const auto outcome =
      binnacle::test::binnacle(bench, {"run", "bad.json", "--set", R"~(/sources/truth/columns/x/missing=["-1"])~"});
  CHECK(outcome.status == 1);
  CHECK(outcome.out.find("walk: never started, 0 steps\n") != std::string::npos);
  CHECK(outcome.err ==
        "bad.json:9:5: error[B081] /filters/walk: filter 'walk' never started: no sample ever came on truth "
        "(it needs truth)\n"
        "1 error\n");
}

namespace {

/// Enough to be caught in the middle of it.
void write_long_data(const Workbench& bench) {
  std::string text = "t,place\n";
  for (int i = 0; i < 400000; ++i) text += std::to_string(i) + ",0.1\n";
  bench.write("fix.csv", text);
}

void wait_for_folder(Command& command, const std::string& folder) {
  while (command.is_running() && !fs::exists(folder)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
}

/// Without hidden ones.
std::vector<std::string> seen_in(const fs::path& folder) {
  auto names = names_in(folder);
  std::erase_if(names, [](const std::string& name) { return name.starts_with("."); });
  return names;
}

}  // namespace

TEST_CASE("interrupted by SIGINT, a run leaves nothing and ends by the signal") {
  const Workbench bench;
  write_long_data(bench);
  const auto before = names_in(bench.folder());
  Command command(bench, {"run", "good.json", "--out", "out", "--summary", "summary.json"});
  wait_for_folder(command, bench.path("out"));
  command.signal(SIGINT);
  const auto outcome = command.wait();
  CHECK(outcome.signal == SIGINT);
  CHECK(outcome.err == "error: interrupted; nothing was written\n");
  CHECK(names_in(bench.folder()) == before);
}

TEST_CASE("killed, a run leaves what an earlier one wrote, and nothing half-written") {
  const Workbench bench;
  REQUIRE(run(bench, {"--out", "out"}).status == 0);
  const auto names = names_in(bench.path("out"));
  const auto record = read_file(bench.path("out/walk.csv"));
  write_long_data(bench);
  Command command(bench, {"run", "good.json", "--out", "out"});
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  command.signal(SIGKILL);
  CHECK(command.wait().signal == SIGKILL);
  CHECK(read_file(bench.path("out/walk.csv")) == record);
  CHECK(seen_in(bench.path("out")) == names);
  // What HDF5 had open could not be nameless; the next run sweeps it away.
  bench.write("fix.csv", "t,place\n0,0.1\n");
  REQUIRE(run(bench, {"--out", "out"}).status == 0);
  CHECK(names_in(bench.path("out")) == names);
}

}  // namespace run_test
