// SPDX-License-Identifier: Apache-2.0
// Latency and history as a user asks for them: what is recorded and emitted, what is said of late samples, what is refused.
#include "catch.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "csv_columns.hpp"

namespace history_test {

using namespace binnacle::test;

namespace {

const std::string quickstart = BINNACLE_TEST_PROJECT "/configs/quickstart.json";
const std::string late = R"(/sources/drive/latency={"uniform": [0, "1.9 s"]})";
const std::string history = "/filters/ins/history=\"2 s\"";

Outcome run(const Workbench& bench, const std::vector<std::string>& sets, std::vector<std::string> options = {}) {
  options.insert(options.begin(), {"run", quickstart});
  for (const auto& set : sets) options.insert(options.end(), {"--set", set});
  return binnacle::test::binnacle(bench, options);
}

std::string sink(const std::string& channel, const std::string& file) {
  return "/sinks/" + file + R"(={"type": "csv_writer", "input": ")" + channel + R"(", "path": ")" + file +
         R"(.csv", "fields": {"height": "position.height"}, "columns": {"height": {"unit": "m"}}})";
}

/// A filter of the height alone, fed by another's estimates.
std::string track(const std::string& channel, const std::string& more = "") {
  return R"(/filters/track={"blocks": {"height": {"type": "vector", "size": 1, "unit": "m", "init": 520, "sigma": "100 m"}},
    "process": {"walk": {"type": "random_walk", "blocks": {"x": "height"}, "q": 1}},
    "measurements": {"its": {"type": "linear_measurement", "channel": ")" +
         channel + R"(", "blocks": {"x": "height"}, "fields": {"z0": "position.height"}, "sigma": ["1 m"]}})" + more +
         "}";
}

}  // namespace

TEST_CASE("recorded and written is what is settled: the files of the ordered run") {
  const Workbench bench;
  REQUIRE(run(bench, {sink("ins", "plain")}, {"--out", "a"}).status == 0);
  const auto outcome = run(bench, {late, history, sink("ins.settled", "settled"), sink("ins", "live")}, {"--out", "b"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  CHECK(read_file(bench.path("b/ins.csv")) == read_file(bench.path("a/ins.csv")));
  CHECK(read_file(bench.path("settled.csv")) == read_file(bench.path("plain.csv")));
  // Live estimates are emitted as samples arrive, and differ.
  const auto live = read_csv(bench.path("live.csv")).columns, settled = read_csv(bench.path("settled.csv")).columns;
  CHECK(live.at(0).size() > settled.at(0).size());
  CHECK(std::ranges::is_sorted(live.at(0)));
  CHECK(outcome.out.find("fix: 1") != std::string::npos);
  CHECK(outcome.out.find("came late, by up to 1.") != std::string::npos);
}

TEST_CASE("a filter fed by settled estimates is that of the ordered run, and without history they are late for it") {
  const Workbench bench;
  const auto figures = [&](const std::vector<std::string>& sets) {
    const auto outcome = run(bench, sets, {"--json", "--out", "out"});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    auto track = nlohmann::json::parse(outcome.out).at("filters").at("track");
    track.erase("filter_s");
    track.erase("waited");  // counted from the first sample that arrives
    for (const char* key : {"replayed", "longest_delay_s"}) track.at("measurements").at("its").erase(key);
    return std::pair(track.dump(), read_file(bench.path("out/track.csv")));
  };
  const auto ordered = figures({track("ins")});
  CHECK(figures({late, history, track("ins.settled", R"(, "history": "2 s")")}) == ordered);
  CHECK(figures({late, history, track("ins.settled")}) == ordered);  // it has no other input
}

TEST_CASE("live estimates are scored if asked, and what latency costs is seen") {
  const Workbench bench;
  const auto rms = [&](const std::vector<std::string>& sets) {
    const auto outcome = run(bench, sets, {"--json"});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    return nlohmann::json::parse(outcome.out)
        .at("filters")
        .at("ins")
        .at("reference")
        .at("position.horizontal")
        .at("rms")
        .get<double>();
  };
  const double settled = rms({late, history}), live = rms({late, history, "/evaluate/estimates=live"});
  CHECK(live > 1.01 * settled);
  CHECK(live < 3 * settled);
}

TEST_CASE("what comes later than the history is not used, and a warning names it") {
  const Workbench bench;
  const auto outcome = run(bench, {late, "/filters/ins/history=\"1 s\""}, {"--json"});
  INFO(outcome.err);
  CHECK(outcome.err.find("B122") != std::string::npos);
  CHECK(outcome.err.find("samples of channel 'drive.imu' came up to 1.") != std::string::npos);
  const auto fix = nlohmann::json::parse(outcome.out).at("filters").at("ins").at("measurements").at("fix");
  CHECK(fix.at("late") > 0);
}

TEST_CASE("a latency that is no time is counted, and the sample arrives at its own") {
  const Workbench bench;
  std::string rows = "t,h,age\n";
  for (int k = 0; k < 50; ++k) rows += std::to_string(k) + ",520," + (k % 10 == 7 ? "-0.1" : "0.2") + "\n";
  bench.write("heights.csv", rows);
  const auto outcome = run(bench, {track("heights"), R"(/sources/heights={"type": "csv/csv", "path": ")" +
                                                         bench.path("heights.csv") + R"(",
      "time": {"column": "t"}, "latency": {"field": "age"},
      "columns": {"position.height": {"column": "h", "unit": "m"}, "age": {"column": "age", "unit": "s"}}})"});
  INFO(outcome.err);
  CHECK(outcome.status == 0);
  CHECK(outcome.err.find("B124") != std::string::npos);
  CHECK(outcome.err.find("/sources/heights/latency") != std::string::npos);
  CHECK(outcome.err.find("5 samples of source 'heights' have a latency that is NaN, infinite or negative") !=
        std::string::npos);
}

TEST_CASE("how far a budget lets live estimates fall behind is in the summary") {
  const Workbench bench;
  const std::string live = "/evaluate/estimates=live";
  const auto bounded = [&](const std::string& steps) {
    const auto outcome =
        run(bench, {late, live, R"(/filters/ins/history={"length": "2 s", "steps": )" + steps + "}"}, {"--json"});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    return nlohmann::json::parse(outcome.out).at("filters").at("ins");
  };
  const auto none = bounded("100000"), small = bounded("20");
  CHECK(!none.contains("longest_lag_s"));
  CHECK(small.at("longest_lag_s") > 0.1);
}

TEST_CASE("mistakes in latency and history are reported at their places") {
  const Workbench bench;
  const auto refused = [&](const std::string& set, const std::string& text) {
    const auto outcome = run(bench, {set});
    CAPTURE(set, outcome.err);
    CHECK(outcome.status == 3);
    CHECK(outcome.err.find(text) != std::string::npos);
  };
  refused("/filters/ins/history=\"2 m\"", "/filters/ins/history");
  refused("/filters/ins/history=0", "/filters/ins/history");
  refused(R"(/filters/ins/history={"steps": 100})", "/filters/ins/history");
  refused(R"(/filters/ins/history={"length": "2 s", "steps": 1})", "/filters/ins/history/steps");
  refused(R"(/filters/ins/history={"length": "2 s", "stpes": 10})", "did you mean 'steps'?");
  refused("/filters/ins/histroy=\"2 s\"", "did you mean 'history'?");
  refused("/sources/drive/latency=\"-1 s\"", "/sources/drive/latency");
  refused(R"(/sources/drive/latency={"unifrom": [0, 1]})", "did you mean 'uniform'?");
  refused(R"(/sources/drive/latency={"uniform": [1]})", "takes two times");
  refused(R"(/sources/drive/latency={"uniform": [2, 1]})", "ends before it begins");
  refused(R"(/sources/drive/latency={"uniform": [0, 1], "exponential": 1})", "'latency' is a time");
  refused(R"(/sources/drive/latency={"field": "age"})", "has no field 'age' for the latency");
  refused("/evaluate/estimates=late", "'estimates' is \"settled\" or \"live\"");
  refused("/filters/ins/measurements/fix/latency=1", "latency");
}

}  // namespace history_test
