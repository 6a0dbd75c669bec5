// SPDX-License-Identifier: Apache-2.0
// Smoothing as a user asks for it: by the config, by --smooth, and what is refused.
#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "csv_columns.hpp"
#include "results/results.hpp"

namespace smooth_test {

using namespace binnacle::test;

namespace {

const std::string quickstart = BINNACLE_TEST_PROJECT "/configs/quickstart.json";

Outcome run(const Workbench& bench, std::vector<std::string> options, const std::string& config = quickstart) {
  options.insert(options.begin(), {"run", config});
  return binnacle::test::binnacle(bench, options);
}

nlohmann::json json_of(const Outcome& outcome) {
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return nlohmann::json::parse(outcome.out).at("filters");
}

}  // namespace

TEST_CASE("run --smooth does what the config's smoother does, and leaves the filter's figures as they are") {
  const Workbench bench;
  const auto plain = json_of(run(bench, {"--json"}));
  const auto by_option = json_of(run(bench, {"--json", "--smooth"}));
  const auto by_config =
      json_of(run(bench, {"--json", "--set", R"(/filters/ins/smoother={"type": "fixed_interval"})"}));
  CHECK(by_option.at("ins").at("reference") == plain.at("ins").at("reference"));
  CHECK(by_option.at("ins.smoothed").at("reference") == by_config.at("ins.smoothed").at("reference"));
  CHECK(by_option.at("ins.smoothed").at("smoother").at("breaks") == 0);
  const auto rms = [](const nlohmann::json& filter, const char* error) {
    return filter.at("reference").at(error).at("rms").get<double>();
  };
  for (const char* error : {"position.height", "velocity.horizontal", "attitude.yaw", "attitude.tilt"}) {
    INFO(error);
    CHECK(rms(by_option.at("ins.smoothed"), error) < 0.7 * rms(by_option.at("ins"), error));
  }
  // Nothing later than the last estimate says more about it.
  CHECK(by_option.at("ins.smoothed").at("reference").at("attitude.yaw").at("final") ==
        by_option.at("ins").at("reference").at("attitude.yaw").at("final"));
}

TEST_CASE("what is smoothed is recorded beside the filter, and a metric has its name") {
  const Workbench bench;
  const auto outcome = run(bench, {"--json", "--smooth", "--out", "out", "--set",
                                   R"(/evaluate/metrics=["ins/attitude.yaw/rms", "ins.smoothed/attitude.yaw/rms"])"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  CHECK(std::filesystem::exists(bench.path("out/ins.smoothed.csv")));
  const auto metrics = nlohmann::json::parse(outcome.out).at("metrics");
  CHECK(metrics.at("ins.smoothed/attitude.yaw/rms").at("value") < metrics.at("ins/attitude.yaw/rms").at("value"));
  const auto config = nlohmann::json::parse(std::ifstream(bench.path("out/config.json")));
  CHECK(config.at("filters").at("ins").at("smoother") == "fixed_interval");
}

TEST_CASE("what a smoother cannot be is refused with the likely intent") {
  const Workbench bench;
  const auto refused = [&](const std::string& set, const std::string& text) {
    const auto outcome = run(bench, {"--set", set});
    INFO(outcome.err);
    CHECK(outcome.status == 3);
    CHECK(outcome.err.find(text) != std::string::npos);
  };
  refused("/filters/ins/smoother=fixed_intervals", "did you mean 'fixed_interval'?");
  refused(R"(/filters/ins/smoother={"typ": "fixed_interval"})", "did you mean 'type'?");
  refused("/filters/ins/smoother=3", "/filters/ins/smoother");
  refused("/filters/ins/smoother=true", "did you mean \"fixed_interval\"? (smoothers: fixed_interval, fixed_lag)");
  refused("/filters/ins/smoother=false", "leave the key out");
  refused("/filters/ins/smoother=fixed_lag", "a fixed lag needs its times");
  refused(R"(/filters/ins/smoother={"type": "fixed_lag"})", "missing key 'lag'");
  refused(R"(/filters/ins/smoother={"type": "fixed_lag", "lag": "5 s", "every": "0 s"})",
          "/filters/ins/smoother/every");
  refused(R"(/filters/ins/smoother={"type": "fixed_lag", "lag": "5 s", "iterations": 3})", "unknown key of 'smoother'");
  const auto nis = run(bench, {"--smooth", "--set", R"(/evaluate/metrics=["ins.smoothed/fix/nis"])"});
  CHECK(nis.status == 3);
  CHECK(nis.err.find("is smoothed and has no innovations; NIS is of 'ins'") != std::string::npos);
}

TEST_CASE("iterations are reported, and why there are none") {
  const Workbench bench;
  const auto smoother = [&](std::vector<std::string> options) {
    options.insert(options.end(),
                   {"--json", "--set", R"(/filters/ins/smoother={"type": "fixed_interval", "iterations": 9})"});
    return nlohmann::json::parse(run(bench, options).out).at("filters").at("ins.smoothed").at("smoother");
  };
  const auto iterated = smoother({});
  CHECK(iterated.at("converged") == true);
  CHECK(iterated.at("iterations") >= 1);
  CHECK(iterated.at("change") < 1e-3);
  const auto opened =
      smoother({"--set", R"(/filters/ins/blocks/attitude/init={"roll": 0, "pitch": 0, "yaw": "50 deg"})", "--set",
                R"(/filters/ins/blocks/attitude/sigma="1 deg")"});
  CHECK(opened.at("iterations") == 0);
  CHECK(opened.at("reason") == "its covariance was opened, or it started anew");
  const auto text = run(bench, {"--set", R"(/filters/ins/smoother={"type": "fixed_interval", "iterations": 9})"}).out;
  CHECK(text.find("ins.smoothed: fixed_interval, 2 iterations, converged (last change ") != std::string::npos);
  CHECK(text.find("; the verdict is that of ins\n") != std::string::npos);
}

TEST_CASE("a lag as long as the run gives what the interval gives, and a shorter one something between") {
  const Workbench bench;
  const auto smoothed = [&](const std::string& smoother) {
    return json_of(run(bench, {"--json", "--set", "/filters/ins/smoother=" + smoother, "--set",
                               R"(/filters/ins/measurements/fix/withhold={"every": 5})"}));
  };
  const auto interval = smoothed(R"("fixed_interval")").at("ins.smoothed");
  const auto whole = smoothed(R"({"type": "fixed_lag", "lag": "1000 s", "every": "30 s"})");
  const auto lagged = smoothed(R"({"type": "fixed_lag", "lag": "10 s"})").at("ins.smoothed");
  const auto& of_whole = whole.at("ins.smoothed");
  for (const auto& [group, name] :
       {std::pair("reference", "attitude.yaw"), std::pair("reference", "position.height")}) {
    const double a = of_whole.at(group).at(name).at("rms"), b = interval.at(group).at(name).at("rms");
    CHECK(std::abs(a - b) < 1e-9 * b);
    CHECK(of_whole.at(group).at(name).at("n") == interval.at(group).at(name).at("n"));
    const double c = lagged.at(group).at(name).at("rms"), d = whole.at("ins").at(group).at(name).at("rms");
    CHECK(c < 0.9 * d);
    CHECK(c != b);
  }
  const auto& withheld = of_whole.at("withheld").at("fix");
  CHECK(withheld.size() > 2);
  for (const auto& [name, figures] : withheld.items()) {
    const auto& others = interval.at("withheld").at("fix").at(name);
    CHECK(figures.at("n") == others.at("n"));
    CHECK(std::abs(figures.at("rms").get<double>() - others.at("rms").get<double>()) < 1e-9);
  }
  CHECK(lagged.at("smoother") ==
        nlohmann::json{{"type", "fixed_lag"}, {"of", "ins"}, {"lag_s", 10.0}, {"every_s", 1.0}, {"breaks", 0}});
}

namespace {

const std::string lag_smoother = R"(/filters/ins/smoother={"type": "fixed_lag", "lag": "20 s", "every": "5 s"})";

}  // namespace

TEST_CASE("what a fixed lag emits is a channel: a sink gets every epoch once, in order, as it is recorded") {
  const Workbench bench;
  const auto outcome =
      run(bench, {"--json", "--out", "out", "--set", lag_smoother, "--set",
                  R"(/sinks={"s": {"type": "csv_writer", "input": "ins.smoothed", "path": "smoothed.csv",
                      "fields": {"height": "position.height"}, "columns": {"height": {"unit": "m"}}}})"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto emitted = read_csv(bench.path("smoothed.csv")).columns;
  const auto filters = binnacle::results::read(bench.path("out")).run->filters;  // all digits
  const auto height_of = [&](const char* name) {
    const auto filter = std::ranges::find(filters, name, &binnacle::results::FilterResults::name);
    REQUIRE(filter != filters.end());
    CHECK(filter->estimates.at(2).output == "height");
    return filter->estimates.at(2).values;
  };
  const auto recorded_height = height_of("ins.smoothed"), forward_height = height_of("ins");
  const auto recorded = read_csv(bench.path("out/ins.smoothed.csv")).columns;
  const auto& times = emitted.at(0);
  CHECK(std::ranges::adjacent_find(times, std::ranges::greater_equal()) == times.end());
  REQUIRE(recorded.at(0).size() > 500);
  int different = 0;
  for (std::size_t k = 0; k < recorded[0].size(); ++k) {
    const auto found = std::ranges::find(times, recorded[0][k]);
    REQUIRE(found != times.end());
    const double height = emitted.at(1)[static_cast<std::size_t>(found - times.begin())];
    CHECK(height == recorded_height.at(k));
    different += height != forward_height.at(k);
  }
  CHECK(different > 500);
  CHECK(times.back() >= recorded[0].back());
}

TEST_CASE("a filter fed by what a fixed lag emits gets every estimate, and may not be smoothed itself") {
  const Workbench bench;
  const std::string fed = R"(/filters/track={
      "blocks": {"height": {"type": "vector", "size": 1, "unit": "m", "init": 520, "sigma": "100 m"}},
      "process": {"walk": {"type": "random_walk", "blocks": {"x": "height"}, "q": 1
}
}
, "measurements" : {
  "smooth" : {
    "type" : "linear_measurement",
             "channel" : "ins.smoothed",
                         "blocks" : {"x" : "height"},
                                    "fields" : {"z0" : "position.height"},
                                               "sigma" : ["1 m"]
  }
}
})";
  const auto outcome = run(bench, {"--json", "--set", lag_smoother, "--set", fed});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto filters = json_of(outcome);
  const auto& counts = filters.at("track").at("measurements").at("smooth");
  CHECK(counts.at("accepted") == counts.at("offered"));
  CHECK(counts.at("accepted") > filters.at("ins").at("steps").get<int>() - 10);
  const auto refused = run(bench, {"--set", lag_smoother, "--set", fed, "--smooth"});
  CHECK(refused.status == 3);
  INFO(refused.err);
  CHECK(refused.err.find("filter 'track' cannot be smoothed: a smoother runs the data again") != std::string::npos);
}

TEST_CASE("without a fixed lag there is no such channel, and a filter may not feed on its own") {
  const Workbench bench;
  const std::string sink =
      R"(/sinks={"s": {"type": "csv_writer", "input": "ins.smoothed", "path": "s.csv", "columns": {}}})";
  for (const char* further : {"--strict", "--smooth"}) {
    const auto outcome = run(bench, {"--set", sink, further});
    CHECK(outcome.status == 3);
    INFO(outcome.err);
    CHECK(outcome.err.find("there is no channel 'ins.smoothed'") != std::string::npos);
  }
  const auto cycle = run(bench, {"--set", lag_smoother, "--set", R"(/filters/ins/measurements/own={
      "type": "linear_measurement", "channel": "ins.smoothed", "blocks": {"x": "accel_bias"},
      "fields": {"z0": "accel_bias.x", "z1": "accel_bias.y", "z2": "accel_bias.z"}, "sigma": [1]})"});
  INFO(cycle.err);
  CHECK(cycle.status == 3);
  CHECK(cycle.err.find("these depend on each other in a cycle") != std::string::npos);
}

}  // namespace smooth_test
