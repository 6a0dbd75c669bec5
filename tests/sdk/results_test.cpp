// SPDX-License-Identifier: Apache-2.0
// results::read(): what --out left, against the CSV, the summary and the command's own figures.
#include "catch.hpp"

#include <bit>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "results/results.hpp"

using namespace binnacle::test;
using nlohmann::json;
namespace fs = std::filesystem;
namespace results = binnacle::results;

namespace {

/// A CSV of numbers: its header's names, and its columns.
struct Csv {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
};

Csv read_csv(const fs::path& path) {
  Csv csv;
  std::istringstream lines(read_file(path));
  std::string line, cell;
  std::getline(lines, line);
  std::istringstream header(line);
  while (std::getline(header, cell, ',')) csv.names.push_back(cell);
  csv.columns.resize(csv.names.size());
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (auto& column : csv.columns) {
      std::getline(cells, cell, ',');
      column.push_back(std::stod(cell));
    }
  }
  return csv;
}

bool are_same(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i]) &&
        !(std::isnan(a[i]) && std::isnan(b[i])))
      return false;
  return true;
}

const std::string quickstart = std::string(BINNACLE_TEST_PROJECT) + "/configs/quickstart.json";

}  // namespace

TEST_CASE("estimates of run.nc are those of the CSV, bit for bit") {
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
    CHECK(are_same(estimate.values, csv.columns[1 + i]));
    CHECK(csv.names[1 + filter.estimates.size() + i] == name + ".sigma[" + estimate.unit + "]");
    CHECK(are_same(estimate.sigma, csv.columns[1 + filter.estimates.size() + i]));
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
