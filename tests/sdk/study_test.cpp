// SPDX-License-Identifier: Apache-2.0
// binnacle study: variants, statistics over runs, tables, and that neither --jobs nor a kill changes a figure.
#include "catch.hpp"

#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "chi_squared/chi_squared.hpp"
#include "command.hpp"
#include "drive_study.hpp"
#include "study/statistics.hpp"

namespace study_test {

using namespace binnacle::test;
using nlohmann::json;
namespace fs = std::filesystem;
namespace study = binnacle::study;

namespace {

/// The good config with a study; the filter knows more or less of how the place wanders.
void write_study(const Workbench& bench, const std::string& section, const std::string& name = "study.json") {
  std::string text = good_config;
  text.insert(text.rfind('}'), ",\n  \"study\": " + section + "\n");
  bench.write(name, text);
}

const char* const two_variants = R"~({
    "runs": 3, "metrics": ["walk/place.x/final"],
    "variants": {
      "calm": { "filters": { "walk": { "process": { "wander": { "q": "0.01 m/sqrt(s)" } } } } },
      "nervous": { "filters": { "walk": { "process": { "wander": { "q": "1 m/sqrt(s)" } } } } }
    }
  })~";

Outcome command(const Workbench& bench, std::vector<std::string> arguments) {
  return binnacle::test::binnacle(bench, arguments);
}

bool near(double a, double b, double tolerance) { return std::abs(a - b) < tolerance; }

}  // namespace

TEST_CASE("statistics over runs and their standard errors are those of a hand calculation") {
  const std::vector<double> x{1, -2, 3, 4};
  CHECK(near(over_runs(x, study::OverRuns::mean), 1.5, 1e-15));
  CHECK(near(over_runs(x, study::OverRuns::rms), std::sqrt(7.5), 1e-15));
  CHECK(near(over_runs(x, study::OverRuns::std), std::sqrt(7.0), 1e-15));  // (0.25 + 12.25 + 2.25 + 6.25) / 3
  CHECK(near(over_runs(x, study::OverRuns::p50), 2.5, 1e-15));             // of 1 2 3 4
  CHECK(near(over_runs(x, study::OverRuns::p95), 3.85, 1e-14));
  CHECK(over_runs(x, study::OverRuns::max) == 4);
  CHECK(near(standard_error(x, study::OverRuns::mean), std::sqrt(7.0) / 2, 1e-15));
  // x² = 1 4 9 16: mean 7.5, std sqrt((42.25 + 12.25 + 2.25 + 72.25) / 3) = sqrt(43)
  CHECK(near(standard_error(x, study::OverRuns::rms), std::sqrt(43.0) / (2 * std::sqrt(7.5) * 2), 1e-15));
  CHECK(std::isnan(standard_error(x, study::OverRuns::p50)));
  CHECK(std::isnan(over_runs({}, study::OverRuns::mean)));
  CHECK(std::isnan(over_runs({1}, study::OverRuns::std)));

  const auto same = ratio_of({0.1, -0.7, 0.3}, {0.1, -0.7, 0.3}, study::OverRuns::rms);
  CHECK(same.value == 1);
  CHECK(same.se == 0);
  const auto half = ratio_of({1, -2, 3, 4}, {2, -4, 6, 8}, study::OverRuns::rms);
  CHECK(near(half.value, 0.5, 1e-15));
  CHECK(near(half.se, 0, 1e-15));  // paired: every run says one half
  // mean: psi = (a_i − 1.5)/2 − 1.5 (b_i − 2)/4 with b = 1 3 1 3
  const auto ratio = ratio_of(x, {1, 3, 1, 3}, study::OverRuns::mean);
  CHECK(near(ratio.value, 0.75, 1e-15));
  const double psi[] = {-0.25 + 0.375, -1.75 - 0.375, 0.75 + 0.375, 1.25 - 0.375};
  double squares = 0;
  for (const double value : psi) squares += value * value;
  CHECK(near(ratio.se, std::sqrt(squares / 3 / 4), 1e-15));
}

TEST_CASE("the band of a mean of chi-squared values is that of the tables") {
  const auto one = binnacle::chi_squared_band(3, 1, 0.99);
  CHECK(near(one.first, 0.0717, 1e-4));
  CHECK(near(one.second, 12.838, 1e-3));
  const auto hundred = binnacle::chi_squared_band(1, 100, 0.99);
  CHECK(near(hundred.first, 0.67328, 1e-4));
  CHECK(near(hundred.second, 1.40169, 1e-4));
}

TEST_CASE("metrics of a run are those of a hand calculation") {
  const Workbench bench;
  std::string text = good_config;
  const std::string key = "\"evaluate\": { ";
  text.insert(text.find(key) + key.size(),
              R"~("metrics": ["walk/place.x/final", "walk/place.x/mean", "walk/place.x/at 2 s",
    "walk/place.x/at start+3 s", "walk/place.x/sigma", "walk/place.x/sigma at 2 s", "walk/place/nees", "walk/place.x/nees", "walk/state/nees", "walk/state/nees at 2 s",
    "walk/seen/nis", {"metric": "walk/place.x/rms", "unit": "mm"}, "walk/place.x/at 5 s"], )~");
  bench.write("metrics.json", text);
  const auto outcome = command(bench, {"run", "metrics.json", "--json"});
  REQUIRE(outcome.status == 0);
  const auto metrics = json::parse(outcome.out).at("metrics");
  const auto value = [&](const char* name) { return metrics.at(name).at("value").get<double>(); };

  double x = 0, p = 1, nis = 0;
  std::vector<double> estimate, sigma;
  for (const double z : {0.1, 0.2, 0.15, 0.3, 0.25}) {
    if (!estimate.empty()) p += 0.01;
    nis += (z - x) * (z - x) / (p + 0.01) / 5;
    const double gain = p / (p + 0.01);
    x += gain * (z - x);
    p *= 1 - gain;
    estimate.push_back(x);
    sigma.push_back(std::sqrt(p));
  }
  const double e1 = 0.2 - estimate[1], e2 = 0.2 - estimate[2], e4 = 0.3 - estimate[4];
  CHECK(near(value("walk/place.x/final"), e4, 1e-12));
  CHECK(near(value("walk/place.x/mean"), (e1 + e2 + e4) / 3, 1e-12));
  CHECK(near(value("walk/place.x/at 2 s"), e2, 1e-12));
  CHECK(near(value("walk/place.x/at start+3 s"), (e2 + e4) / 2, 1e-12));
  CHECK(near(value("walk/place.x/sigma"), sigma[4], 1e-12));
  CHECK(near(value("walk/place.x/sigma at 2 s"), sigma[2], 1e-12));
  const double nees = (std::pow(e1 / sigma[1], 2) + std::pow(e2 / sigma[2], 2) + std::pow(e4 / sigma[4], 2)) / 3;
  CHECK(near(value("walk/place/nees"), nees, 1e-12));
  CHECK(near(value("walk/place.x/nees"), nees, 1e-12));
  CHECK(near(value("walk/state/nees"), nees, 1e-12));
  CHECK(near(value("walk/state/nees at 2 s"), std::pow(e2 / sigma[2], 2), 1e-12));
  CHECK(near(value("walk/seen/nis"), nis, 1e-12));
  CHECK(near(value("walk/place.x/rms"), 1000 * std::sqrt((e1 * e1 + e2 * e2 + e4 * e4) / 3), 1e-9));
  CHECK(metrics.at("walk/place.x/rms").at("unit") == "mm");
  CHECK(metrics.at("walk/place.x/at 5 s").at("value").is_null());  // after the last of the reference
}

TEST_CASE("jobs change no figure, and every run can be repeated alone") {
  const Workbench bench;
  write_drive(bench);
  const auto one = command(bench, {"study", "drive.json", "--jobs", "1", "--out", "one"});
  CHECK(one.err.empty());
  REQUIRE(one.status == 0);
  const auto two = command(bench, {"study", "drive.json", "--jobs", "2", "--out", "two", "--summary", "two.json"});
  REQUIRE(two.status == 0);
  check_same_files(bench, "one", "two");

  auto summary = json::parse(read_file(bench.path("two.json")));
  CHECK(summary.at("wall_s").get<double>() > 0);
  summary.erase("wall_s");
  CHECK(summary == json::parse(read_file(bench.path("two/study.json"))));
  CHECK(summary.at("runs") == 6);
  CHECK(summary.at("seed") == 7);
  const auto& entry = summary.at("variants").at("bad off");
  CHECK(entry.at("runs") == 6);
  CHECK(entry.at("failed") == 0);
  const auto& yaw = entry.at("metrics").at("ins/attitude.yaw/final");
  for (const char* key : {"rms", "mean", "std", "se", "se_rms", "p50", "p95"}) CHECK(yaw.at(key).is_number());
  CHECK(yaw.at("unit") == "mil");
  // A mil is 1/6400 of a turn, an arcmin 1/21600.
  CHECK(near(summary.at("table").at("cells")[1][1].get<double>(), yaw.at("rms").get<double>() * 21600 / 6400, 1e-9));
  CHECK(entry.at("metrics").at("ins/position/nees").at("band").size() == 2);

  const auto alone =
      command(bench, {"run", "drive.json", "--variant", "bad off", "--seed", "7", "--run", "4", "--json"});
  REQUIRE(alone.status == 0);
  const auto value = json::parse(alone.out).at("metrics").at("ins/position.horizontal/rms").at("value");
  CHECK(read_file(bench.path("one/study.csv"))
            .find("\nbad off,4,7,ins/position.horizontal/rms," + value.dump() + ",m\n") != std::string::npos);
  CHECK(json::parse(alone.out).at("filters").at("ins").at("reference").contains("position.horizontal"));
}

TEST_CASE("a study that was killed goes on where it was, and its files are those of another") {
  const Workbench bench;
  write_drive(bench);
  REQUIRE(command(bench, {"study", "drive.json", "--runs", "20", "--jobs", "2", "--out", "whole"}).status == 0);
  for (const int signal : {SIGKILL, SIGINT}) {
    const std::string folder = "cut" + std::to_string(signal), journal = bench.path(folder + "/study.journal");
    Command running(bench, {"study", "drive.json", "--runs", "20", "--jobs", "1", "--out", folder});
    while (running.is_running() && lines_in(journal) < 4) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    running.signal(signal);
    const auto outcome = running.wait();
    REQUIRE(outcome.signal == signal);
    if (signal == SIGINT) CHECK(outcome.err == "error: interrupted; the same command continues from here\n");
    CHECK_FALSE(fs::exists(bench.path(folder + "/study.csv")));
    const auto kept = lines_in(journal) - 1;
    REQUIRE(kept >= 3);
    std::ofstream(journal, std::ios::app) << "[0,5,[[1,0,";  // torn in the middle

    const auto rest = command(bench, {"study", "drive.json", "--runs", "20", "--jobs", "2", "--out", folder});
    CHECK(rest.err == std::to_string(kept) + " of 80 runs are in the journal\n");
    REQUIRE(rest.status == 0);
    check_same_files(bench, "whole", folder);
    CHECK(lines_in(journal) == 81);
  }
}

TEST_CASE("the journal of another study is refused, with the remedy") {
  const Workbench bench;
  write_study(bench, two_variants);
  REQUIRE(command(bench, {"study", "study.json", "--out", "out"}).status == 0);
  const auto seed = command(bench, {"study", "study.json", "--out", "out", "--seed", "2"});
  CHECK(seed.status == 2);
  CHECK(seed.err ==
        "out/study.journal:1: error[B092]: this journal is of a study with another seed; give another --out, or delete "
        "the file to start again\n1 error\n");
  const auto config =
      command(bench, {"study", "study.json", "--out", "out", "--set", "/filters/walk/blocks/place/sigma=2"});
  CHECK(config.status == 2);
  CHECK(config.err ==
        "out/study.journal:1: error[B092]: this journal is of a study with another config, program or plugin; give "
        "another --out, or delete the file to start again\n1 error\n");
  // More runs, another title or table: the same study.
  const auto more = command(bench, {"study", "study.json", "--out", "out", "--runs", "4", "--quiet"});
  CHECK(more.status == 0);
  CHECK(more.err.empty());
  CHECK(lines_in(bench.path("out/study.journal")) == 9);
}

TEST_CASE("a run that breaks is reported with what repeats it, and the others go on") {
  const Workbench bench;
  std::string section = two_variants;
  section.replace(section.find("\"1 m/sqrt(s)\""), 13, "\"1e200 m/sqrt(s)\"");
  write_study(bench, section);
  const auto outcome = command(bench, {"study", "study.json", "--runs", "2", "--json"});
  CHECK(outcome.status == 1);
  const std::string broke =
      "filter 'walk' broke: plugin 'core', component 'random_walk' (/filters/walk/process/wander): propagate at 1 s "
      "gave 'place.x' the process noise inf, which is not a variance; to see it: binnacle run study.json --variant "
      "nervous --seed 1 ";
  CHECK(outcome.err == "study.json: error[B093]: variant 'nervous', seed 1, run 0: " + broke +
                           "--run 0\nstudy.json: error[B093]: variant 'nervous', seed 1, run 1: " + broke +
                           "--run 1\nerror: 2 of 4 runs broke\n");
  const auto variants = json::parse(outcome.out).at("variants");
  CHECK(variants.at("calm").at("failed") == 0);
  CHECK(variants.at("calm").at("metrics").at("walk/place.x/final").at("n") == 2);
  CHECK(variants.at("nervous").at("failed") == 2);
  CHECK(variants.at("nervous").at("failures")[1].at("run") == 1);
  CHECK(command(bench, {"run", "study.json", "--variant", "nervous", "--quiet"}).status == 1);
  CHECK(command(bench, {"run", "study.json", "--variant", "calm", "--quiet"}).status == 0);
}

TEST_CASE("what is wrong with a study is reported before anything runs") {
  const Workbench bench;
  const auto is_reported = [&](const std::string& section, const std::string& message, int line = 26) {
    write_study(bench, section);
    for (const char* verb : {"study", "check"}) {
      const auto outcome = command(bench, {verb, "study.json"});
      CHECK(outcome.err == "study.json:" + std::to_string(line) + ":" + message + "\n1 error\n");
      CHECK(outcome.status == 3);
    }
  };
  is_reported(
      R"~({ "metrics": ["walk/place.y/rms"] })~",
      "26: error[B027] /study/metrics/0: metric 'walk/place.y/rms': no 'place.y' of filter 'walk' is scored by a "
      "reference; did you mean 'place.x'? (there are: place.x)");
  is_reported(
      R"~({ "metrics": ["walk/place.x/rsm"] })~",
      "26: error[B027] /study/metrics/0: metric 'walk/place.x/rsm': there is no statistic 'rsm'; did you mean "
      "'rms'? (statistics: mean, rms, max, final, drift, p50, p95, sigma, nees, nis, at 100 s, translation, rotation)");
  is_reported(R"~({ "metrics": ["wlak/place.x/rms"] })~",
              "26: error[B027] /study/metrics/0: metric 'wlak/place.x/rms': there is no filter 'wlak'; did you mean "
              "'walk'? (filters: walk)");
  is_reported(
      R"~({ "metrics": [{ "metric": "walk/place.x/rms", "unit": "deg" }] })~",
      "66: error[B007] /study/metrics/0/unit: metric 'walk/place.x/rms' is a length (m); 'deg' is an angle (rad)");
  is_reported(R"~({ "runs": 2 })~",
              "3: error[B010] /study: missing key 'metrics': what a study reports, \"FILTER/BLOCK.OUTPUT/STATISTIC\"");
  is_reported(R"~({ "rns": 2, "metrics": ["walk/place.x/rms"] })~",
              "14: error[B012] /study/rns: unknown key of 'study'; did you mean 'runs'? (keys: runs, seed, dimensions, "
              "variants, metrics, table, tables)");
  is_reported(
      R"~({ "metrics": ["walk/place.x/rms"], "variants": { "a": {}, "b": {} }, "table": { "rows": ["a", "c"] } })~",
      "90: error[B090] /study/table: there is no variant 'c', the cell of row 'c', column 'rms' (variants: a, b)");
  is_reported(R"~({ "metrics": ["walk/place.x/rms"], "dimensions": { "d": { "a": {} } }, "variants": { "a": {} } })~",
              "97: error[B091] /study/variants/a: the dimensions make a variant 'a' already");
  is_reported(R"~({ "metrics": ["walk/place.x/rms"], "table": { "paper": [[1, 2]] } })~",
              "68: error[B013] /study/table/paper/0: 'paper' has 1 column here, as the table has; found 2");
  is_reported(R"~({ "metrics": ["walk/place.x/rms"], "variants": { "a": {},
    "b": { "filters": { "walk": { "blocks": { "place": { "size": -1 } } } } } } })~",
              "66: error[B009] /filters/walk/blocks/place/size: 'size' is -1, out of range (>= 1, <= 64) (variant 'b')",
              27);

  write_study(bench, two_variants);
  const auto outcome = command(bench, {"run", "study.json", "--variant", "clam"});
  CHECK(outcome.status == 3);
  CHECK(outcome.err ==
        "study.json:26:3: error[B090] /study: there is no variant 'clam'; did you mean 'calm'? (variants: calm, "
        "nervous)\n"
        "1 error\n");
  CHECK(command(bench, {"check", "study.json"}).status == 0);
}

TEST_CASE("a metric that no variant knows is misspelt, wherever it stands, and one that some lack is not") {
  const Workbench bench;
  const auto with_metrics = [&](const std::string& metrics, const std::string& variants) {
    std::string text = good_config;
    const std::string from = R"~("evaluate": {)~";
    text.replace(text.find(from), from.size(), from + R"~( "metrics": )~" + metrics + ",");
    text.insert(text.rfind('}'),
                ",\n  \"study\": { \"metrics\": [\"walk/place.x/rms\"], \"variants\": " + variants + "}\n");
    bench.write("study.json", text);
  };
  const std::string listed =
      " /evaluate/metrics/0: metric 'walk/place.x/rsm': there is no statistic 'rsm'; did you mean 'rms'? (statistics: "
      "mean, rms, max, final, drift, p50, p95, sigma, nees, nis, at 100 s, translation, rotation)";
  const auto each = [&](const auto& look) {
    for (const auto& arguments : {std::vector<std::string>{"check", "study.json"},
                                  {"study", "study.json"},
                                  {"run", "study.json", "--variant", "a"}})
      look(command(bench, arguments), arguments.front());
  };
  // In the variant's own patch: at its place there.
  with_metrics("[]", R"~({ "a": { "evaluate": { "metrics": ["walk/place.x/rsm"] } }, "b": {} })~");
  each([&](const Outcome& outcome, const std::string& verb) {
    INFO(verb << ": " << outcome.err);
    CHECK(outcome.status == 3);
    const std::string whose = verb == "run" ? "" : " (variant 'a')";
    CHECK(outcome.err == "study.json:26:94: error[B027]" + listed + whose + "\n1 error\n");
  });
  // Among those of all variants.
  with_metrics(R"~(["walk/place.x/rsm"])~", R"~({ "a": {}, "b": {} })~");
  each([&](const Outcome& outcome, const std::string& verb) {
    INFO(verb << ": " << outcome.err);
    CHECK(outcome.status == 3);
    CHECK(outcome.err == "study.json:24:29: error[B027]" + listed + "\n1 error\n");
  });
  // Variant a has no reference, so no error to make the metric of.
  with_metrics(R"~(["walk/place.x/rms"])~", R"~({ "a": { "reference": null }, "b": {} })~");
  CHECK(command(bench, {"run", "study.json", "--variant", "a", "--quiet"}).status == 0);
  CHECK(command(bench, {"run", "study.json", "--variant", "b", "--quiet"}).status == 0);
}

TEST_CASE("tables are laid out as the config says, beside the paper's") {
  const Workbench bench;
  write_study(bench, R"~({
    "runs": 2, "metrics": ["walk/place.x/final"],
    "dimensions": {
      "q": { "calm": { "filters": { "walk": { "process": { "wander": { "q": "0.01 m/sqrt(s)" } } } } },
             "nervous": { "filters": { "walk": { "process": { "wander": { "q": "1 m/sqrt(s)" } } } } } },
      "sigma": { "x1": {}, "x2": { "filters": { "walk": { "measurements": { "seen": { "sigma": ["0.2 m"] } } } } } } },
    "tables": [
      { "title": "Error at the end", "rows": ["calm", "nervous"], "columns": ["x1", "x2"], "unit": "mm",
        "paper": [[100, null], [50, 51.5]] },
      { "rows": ["calm", { "name": "wild", "as": "nervous" }],
        "columns": [ { "name": "error", "cell": "{row} x1" },
                     { "name": "better than x2 by", "cell": "{row} x1", "baseline": "{row} x2" },
                     { "name": "of calm", "cell": "{row} x1", "baseline": "calm x1", "show": "ratio" },
                     { "name": "none", "cell": "" } ] } ]
  })~");
  const auto outcome = command(bench, {"study", "study.json", "--out", "out"});
  REQUIRE(outcome.status == 0);
  const std::string expected = R"~(A place that wanders

  walk/place.x/final [m]      rms     mean  std      p50      p95  runs
  calm x1                 0.09853  0.09853    0  0.09853  0.09853     2
  calm x2                  0.1011   0.1011    0   0.1011   0.1011     2
  nervous x1              0.04952  0.04952    0  0.04952  0.04952     2
  nervous x2              0.04835  0.04835    0  0.04835  0.04835     2

Error at the end [mm]
              x1            x2
            here  paper   here  paper
  calm     98.53    100  101.1      -
  nervous  49.52     50  48.35   51.5

        error [m]  better than x2 by [%]  of calm  none
  calm    0.09853                  2.537    1.000     -
  wild    0.04952                 -2.429   0.5026     -

)~";
  CHECK(outcome.out.substr(0, outcome.out.rfind("8 runs, seed 1, wall time ")) == expected);
  const auto summary = json::parse(read_file(bench.path("out/study.json")));
  CHECK(summary.at("tables").size() == 2);
  CHECK(summary.at("table") == summary.at("tables")[0]);
  CHECK(summary.at("table").at("rows") == json({"calm", "nervous"}));
  CHECK(summary.at("table").at("paper")[0][1].is_null());
  CHECK(read_file(bench.path("out/table.csv"))
            .starts_with("table,row,column,value,se,unit,paper\nError at the end,calm,x1,98.5303810427"));
}

TEST_CASE("a cell may have a text instead of a figure, and figures may have the other sign") {
  const Workbench bench;
  write_study(bench, R"~({ "runs": 1, "metrics": ["walk/place.x/final", "walk/place.x/drift"],
    "variants": { "calm": {} },
    "table": { "rows": ["calm", "stormy"], "texts": { "stormy": "too rough" }, "statistic": "mean",
      "columns": [ { "name": "final", "cell": "{row}", "metric": "walk/place.x/final" },
                   { "name": "reversed", "cell": "{row}", "metric": "walk/place.x/final", "sign": "estimate - truth" },
                   { "name": "drift", "cell": "{row}", "metric": "walk/place.x/drift" } ] } })~");
  const auto outcome = command(bench, {"study", "study.json", "--out", "out"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto summary = json::parse(read_file(bench.path("out/study.json")));
  const auto& cells = summary.at("table").at("cells");
  CHECK(cells[1] == json({"too rough", "too rough", "too rough"}));
  CHECK(cells[0][1].get<double>() == -cells[0][0].get<double>());
  CHECK(std::abs(cells[0][2].get<double>()) < 1);
  CHECK(outcome.out.find("too rough  too rough\n") != std::string::npos);
  CHECK(read_file(bench.path("out/table.csv")).find("stormy,final,too rough,") != std::string::npos);

  write_study(bench, R"~({ "runs": 1, "metrics": ["walk/place.x/final"], "variants": { "calm": {} },
    "table": { "rows": ["calm"], "texts": { "clam": "too rough" } } })~");
  const auto unused = command(bench, {"study", "study.json"});
  CHECK(unused.status == 3);
  CHECK(unused.err.find("error[B090] /study/table/texts/clam: no cell of the table would be 'clam'") !=
        std::string::npos);
}

}  // namespace study_test
