// SPDX-License-Identifier: Apache-2.0
// results::read(): what --out left, against the CSV, the summary and the command's own figures.
#include "catch.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "csv_columns.hpp"
#include "file_size_limit.hpp"
#include "results/results.hpp"

namespace results_test {

using namespace binnacle::test;
using nlohmann::json;
namespace fs = std::filesystem;
namespace results = binnacle::results;

namespace {

bool are_same(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i]) &&
        !(std::isnan(a[i]) && std::isnan(b[i])))
      return false;
  return true;
}

bool are_as_stated(const std::string& header, const std::vector<double>& exact, const std::vector<double>& read) {
  bool are = exact.size() == read.size();
  for (std::size_t i = 0; are && i < exact.size(); ++i) are = is_as_stated(header, exact[i], read[i]);
  return are;
}

/// What the words print, and their exit status.
struct Said {
  std::string text;
  int status = -1;
};
Said said_by(const std::string& words) {
  Said said;
  FILE* const pipe = popen((words + " 2>&1").c_str(), "r");
  for (int c = 0; (c = fgetc(pipe)) != EOF;) said.text += static_cast<char>(c);
  said.status = pclose(pipe);
  return said;
}

Said python(const std::string& script, const std::string& folder) {
  return said_by(std::string(BINNACLE_TEST_PYTHON) + " '" + BINNACLE_TEST_PROJECT + "/tests/sdk/" + script + "' '" +
                 folder + "'");
}

/// The one line of what read() throws; "" where it reads it all.
std::string complaint_of(const fs::path& folder) {
  try {
    results::read(folder);
  } catch (const std::runtime_error& error) {
    const std::string line = error.what();
    CHECK(line.find('\n') == std::string::npos);
    return line;
  }
  return "";
}

const std::string quickstart = std::string(BINNACLE_TEST_PROJECT) + "/configs/quickstart.json";

}  // namespace

TEST_CASE("estimates of run.nc are those of the CSV, to the digits that are stated") {
  const Workbench bench;
  REQUIRE(binnacle::test::binnacle(bench, {"run", quickstart, "--out", "out", "--quiet"}).status == 0);
  const auto all = results::read(bench.path("out"));
  REQUIRE(all.run);
  CHECK_FALSE(all.study);
  REQUIRE(all.run->filters.size() == 1);
  const auto& filter = all.run->filters[0];
  CHECK(filter.name == "ins");
  const auto csv = read_csv(bench.path("out/ins.csv"));
  CHECK(are_same(filter.t, csv.columns[0]));
  REQUIRE(csv.names.size() == 1 + 2 * filter.estimates.size());
  for (std::size_t i = 0; i < filter.estimates.size(); ++i) {
    const auto& estimate = filter.estimates[i];
    const std::string name = estimate.block + "." + estimate.output;
    CHECK(csv.names[1 + i] == name + "[" + estimate.unit + "]");
    CHECK(are_as_stated(csv.names[1 + i], estimate.values, csv.columns[1 + i]));
    CHECK(csv.names[1 + filter.estimates.size() + i] == name + ".sigma[" + estimate.unit + "]");
    CHECK(are_as_stated(csv.names[1 + filter.estimates.size() + i], estimate.sigma,
                        csv.columns[1 + filter.estimates.size() + i]));
  }
}

TEST_CASE("errors and outcomes of run.nc make the figures of the summary") {
  const Workbench bench;
  REQUIRE(binnacle::test::binnacle(bench, {"run", quickstart, "--out", "out", "--quiet"}).status == 0);
  const auto run = *results::read(bench.path("out")).run;
  const auto& filter = run.filters.at(0);
  const auto& summary = run.summary.at("filters").at("ins");
  std::size_t compared = 0;
  for (const auto& error : filter.errors) {
    REQUIRE(error.t.size() == error.values.size());
    REQUIRE((error.sigma.empty() || error.sigma.size() == error.values.size()));
    if (!summary.at("reference").contains(error.name)) continue;
    const auto& figures = summary.at("reference").at(error.name);
    CHECK(figures.at("unit") == error.display_unit);
    const double scale = error.display_unit == "deg" ? 180 / std::numbers::pi : 1;
    double squares = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < error.t.size(); ++i) {
      if (error.t[i] < summary.at("start_s").get<double>() + 10) continue;  // as the config says
      squares += error.values[i] * error.values[i];
      ++n;
    }
    CHECK(n == figures.at("n").get<std::size_t>());
    const double rms = figures.at("rms").get<double>();
    CHECK(std::abs(std::sqrt(squares / static_cast<double>(n)) * scale - rms) < 1e-9 * rms);
    ++compared;
  }
  CHECK(compared == summary.at("reference").size());
  REQUIRE(filter.updates.size() == 1);
  const auto& updates = filter.updates[0];
  double nis = 0;
  std::int64_t accepted = 0, rows = 0;
  for (std::size_t i = 0; i < updates.t.size(); ++i) {
    rows += updates.rows[i];
    if (updates.outcome[i] != binnacle::Outcome::accepted) continue;
    ++accepted;
    nis += updates.nis[i];
  }
  CHECK(accepted == summary.at("measurements").at("fix").at("accepted").get<std::int64_t>());
  CHECK(std::abs(nis / static_cast<double>(accepted) -
                 summary.at("measurements").at("fix").at("nis_mean").get<double>()) < 1e-12);
  CHECK(updates.residual.size() == static_cast<std::size_t>(rows));
}

TEST_CASE("provenance and config of run.nc are those of the run") {
  const Workbench bench;
  REQUIRE(binnacle::test::binnacle(bench, {"run", "good.json", "--out", "out", "--quiet", "--seed",
                                           "18446744073709551615", "--run", "3", "--set", "/title=It's another"})
              .status == 0);
  const auto run = *results::read(bench.path("out")).run;
  CHECK(run.config == results::Json::parse(read_file(bench.path("out/config.json"))));
  CHECK(run.provenance.at("seed") == 18446744073709551615u);
  CHECK(run.provenance.at("run") == 3);
  CHECK(run.provenance.at("command") ==
        "binnacle run good.json --set '/title=It'\\''s another' --seed 18446744073709551615 --run 3");
  bool has_core = false;
  for (const auto& plugin : run.provenance.at("plugins"))
    has_core |= plugin.at("name") == "core" && fs::exists(plugin.at("path").get<std::string>());
  CHECK(has_core);
}

TEST_CASE("times of run.nc are the doubles nearest to the nanosecond") {
  const Workbench bench;
  bench.write("fix.csv", "t,place\n1600000000.123456789,0.1\n1600000001.000000001,0.2\n");
  REQUIRE(binnacle::test::binnacle(bench, {"run", "good.json", "--out", "out", "--quiet"}).status == 0);
  const auto run = *results::read(bench.path("out")).run;
  CHECK(run.filters.at(0).t == std::vector<double>{1600000000.123456789, 1600000001.000000001});
}

TEST_CASE("every outcome has its reason, and rows only where there were some") {
  const Workbench bench;
  bench.write("fix.csv", "t,place\n0,0.1\n1,90\n2,0.15\n3,0.3\n4,0.25\n");
  bench.spoil("\"gate\": 0.999", "\"gate\": 0.999, \"withhold\": [[\"2.5 s\", \"3.5 s\"]]");
  REQUIRE(binnacle::test::binnacle(bench, {"run", "bad.json", "--out", "out", "--quiet"}).status == 0);
  const auto run = *results::read(bench.path("out")).run;
  const auto& updates = run.filters.at(0).updates.at(0);
  using binnacle::Outcome;
  CHECK(updates.outcome ==
        std::vector{Outcome::accepted, Outcome::gated, Outcome::accepted, Outcome::withheld, Outcome::accepted});
  CHECK(updates.reason[0].empty());
  CHECK_FALSE(updates.reason[1].empty());
  CHECK(updates.rows == std::vector<std::int32_t>{1, 1, 1, 1, 1});
  REQUIRE(updates.residual.size() == 5);
  CHECK(updates.residual[1] > 80);
  CHECK(std::abs(updates.residual[1] * updates.residual[1] / (updates.sigma[1] * updates.sigma[1]) - updates.nis[1]) <
        1e-9 * updates.nis[1]);
  for (const double noise : updates.noise) CHECK(std::abs(noise - 0.1) < 1e-15);
}

TEST_CASE("HDF5 alone reads run.nc and study.nc: the numbers of the CSV, units, dimensions, outcomes") {
  const Workbench bench;
  REQUIRE(binnacle::test::binnacle(bench, {"run", quickstart, "--out", "out", "--quiet"}).status == 0);
  const auto run = python("read_run.py", bench.path("out"));
  INFO(run.text);
  CHECK(run.status == 0);
  CHECK(run.text == "30 columns are the same\n");

  bench.write("study.json", std::string(good_config).insert(std::string(good_config).rfind('}'), R"~(,
    "study": { "runs": 3, "metrics": ["walk/place.x/final", "walk/place.x/rms"],
               "variants": { "calm": {}, "other": { "filters": { "walk": { "blocks": { "place": { "sigma": "2 m" } } } } } },
               "table": { "title": "Both", "rows": ["calm", "other"], "columns": ["rms"], "cells": "{row}",
                          "metric": "walk/place.x/rms" } })~"));
  REQUIRE(binnacle::test::binnacle(bench, {"study", "study.json", "--out", "study", "--quiet"}).status == 0);
  const auto study = python("read_study.py", bench.path("study"));
  INFO(study.text);
  CHECK(study.status == 0);
  CHECK(study.text == "12 values are the same\n");
}

TEST_CASE("a study is read as it was written") {
  const Workbench bench;
  bench.write("study.json", std::string(good_config).insert(std::string(good_config).rfind('}'), R"~(,
    "study": { "runs": 2, "seed": 5, "metrics": ["walk/place.x/final"],
               "variants": { "calm": {}, "wild": { "filters": { "walk": { "process": { "wander": { "q": "1e200 m/sqrt(s)" } } } } } } })~"));
  CHECK(binnacle::test::binnacle(bench, {"study", "study.json", "--out", "out", "--quiet"}).status == 1);
  const auto study = *results::read(bench.path("out")).study;
  CHECK(study.variants == std::vector<std::string>{"calm", "wild"});
  CHECK(study.runs == 2);
  REQUIRE(study.metrics.size() == 1);
  CHECK(study.metrics[0].name == "walk/place.x/final");
  CHECK(study.metrics[0].si_unit == "m");
  REQUIRE(study.values.size() == 4);
  CHECK(study.values[0] == study.values[1]);  // nothing of it is random
  CHECK(std::abs(
            study.values[0] -
            study.figures.at("variants").at("calm").at("metrics").at("walk/place.x/final").at("mean").get<double>()) <
        1e-15);
  CHECK(std::isnan(study.values[2]));
  CHECK(std::isnan(study.values[3]));
  CHECK(study.config.at("study").at("runs") == 2);
  CHECK(study.provenance.at("command") == "binnacle study study.json --runs 2 --seed 5");
  CHECK_FALSE(study.provenance.contains("created"));
}

TEST_CASE("the same run makes the same run.nc, but for the time of making") {
  const Workbench bench;
  setenv("SOURCE_DATE_EPOCH", "1700000000", 1);
  for (const char* folder : {"one", "two"})
    REQUIRE(binnacle::test::binnacle(bench, {"run", quickstart, "--out", folder, "--quiet"}).status == 0);
  unsetenv("SOURCE_DATE_EPOCH");
  CHECK(read_file(bench.path("one/run.nc")) == read_file(bench.path("two/run.nc")));
  CHECK(results::read(bench.path("one")).run->provenance.at("created") == "2023-11-14T22:13:20Z");
}

TEST_CASE("a file that finds no room leaves nothing, exit status 5") {
  const Workbench bench;
  REQUIRE(binnacle::test::binnacle(bench, {"run", quickstart, "--out", "out", "--quiet"}).status == 0);
  const auto size = fs::file_size(bench.path("out/run.nc"));
  REQUIRE(size > fs::file_size(bench.path("out/ins.csv")));
  for (const auto limit : {std::uintmax_t{0}, std::uintmax_t{4096}, size / 8, size * 3 / 4, size - 100}) {
    INFO("limit " << limit << " of " << size);
    const FileSizeLimit lowered(std::max<std::uintmax_t>(limit, 1000));  // what it says has to go somewhere
    const auto outcome = binnacle::test::binnacle(bench, {"run", quickstart, "--out", "full", "--quiet"});
    CHECK(outcome.status == 5);
    CHECK(outcome.err.starts_with("error: 'full/"));
    CHECK(outcome.err.ends_with(
        " could not be written: File too large; raise the limit (ulimit -f), or write elsewhere\n"));
    CHECK_FALSE(fs::exists(bench.path("full")));
  }
}

TEST_CASE("read() states in a line what is wrong with a folder") {
  const Workbench bench;
  const auto said = [&](const std::string& name) { return complaint_of(bench.path(name)); };
  CHECK(said("nowhere") == "'" + bench.path("nowhere") + "' is not a folder");
  CHECK(said("").find("holds neither run.nc nor study.nc; make one with 'binnacle run CONFIG --out ") !=
        std::string::npos);

  REQUIRE(binnacle::test::binnacle(bench, {"run", "good.json", "--out", "out", "--quiet"}).status == 0);
  const std::string whole = read_file(bench.path("out/run.nc"));
  const auto said_of = [&](const std::string& bytes) {
    bench.write("out/run.nc", bytes);
    const std::string line = said("out");
    CHECK(line.starts_with("'" + bench.path("out/run.nc") + "' cannot be read: "));
    CHECK(line.ends_with("; make it again with 'binnacle run CONFIG --out " + bench.path("out") + "'"));
    return line;
  };
  CHECK(said_of("no NetCDF at all\n").find("Unknown file format") != std::string::npos);
  said_of("");
  for (const std::size_t cut : {std::size_t{8}, whole.size() / 2, whole.size() - 1}) said_of(whole.substr(0, cut));
  // An empty NetCDF file of the classic kind.
  CHECK(said_of(std::string("CDF\x01", 4) + std::string(28, '\0')).find("not one from Binnacle") != std::string::npos);

  bench.write("out/run.nc", whole);
  CHECK(said("out").empty());
  fs::copy_file(bench.path("out/run.nc"), bench.path("out/study.nc"));
  CHECK(said("out").find("study.nc' cannot be read: it is no study") != std::string::npos);
  fs::remove(bench.path("out/study.nc"));
  fs::rename(bench.path("out/summary.json"), bench.path("summary.json"));
  CHECK(said("out").find("summary.json' cannot be read: it is missing") != std::string::npos);
  bench.write("out/summary.json", "{ \"filters\": ");
  CHECK(said("out").find("summary.json' cannot be read: it is not a JSON object") != std::string::npos);
}

TEST_CASE("ncdump shows what is in run.nc") {
  const Workbench bench;
  REQUIRE(binnacle::test::binnacle(bench, {"run", quickstart, "--out", "out", "--quiet"}).status == 0);
  const auto said = said_by("ncdump -h '" + bench.path("out/run.nc") + "'");
  CHECK(said.status == 0);
  for (const char* part :
       {"group: ins {", "double attitude(time, attitude_component) ;", "velocity:units = \"m/s\" ;",
        "attitude:display_units = \"deg\" ;", "group: errors {", "group: fix {", ":Conventions = \"CF-1.10\" ;",
        "outcome:flag_meanings = \"accepted gated late unsupported invalid withheld rejected\" ;"})
    CHECK(said.text.find(part) != std::string::npos);
}

}  // namespace results_test
