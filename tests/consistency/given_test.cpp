// SPDX-License-Identifier: Apache-2.0
// Satellites given by their rows, three systems with an offset each: NEES and NIS over Monte Carlo runs are those of
// chi-square, and those of a filter that does not know the offsets are not.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include <boost/math/distributions/chi_squared.hpp>

#include "catch.hpp"
#include "score/run.hpp"

namespace given_test {

using namespace binnacle;

namespace {

constexpr int runs = 60;

/// Whether the mean of `count` χ² variables of `dof` each lies where it does with the given probability.
bool is_chi_square(double mean, double dof, double count, double probability) {
  const boost::math::chi_squared distribution(dof * count);
  const double tail = (1 - probability) / 2;
  const double low = boost::math::quantile(distribution, tail) / count;
  const double high = boost::math::quantile(boost::math::complement(distribution, tail)) / count;
  std::printf("  %8.3f in %.3f … %.3f of %.2f dof\n", mean, low, high, dof);
  return low <= mean && mean <= high;
}

struct Found {
  int outside = 0;  // of four blocks at one instant, all of which hold at once with 99 %
  bool nis_is_inside = false;
};

Found monte_carlo(const char* title, std::vector<std::string> sets) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  // One instant, near the end: errors at one are independent between runs, not between instants.
  sets.insert(sets.end(), {"/evaluate/after=149.5", "/evaluate/until=150.5"});
  options.sets = std::move(sets);
  const auto composition = score::load(BINNACLE_TEST_PROJECT "/tests/consistency/given.json", options);
  std::map<std::string, double> nees, dof;
  double nis = 0, rows = 0, samples = 0;
  for (int run = 0; run < runs; ++run) {
    score::RunOptions of_run;
    of_run.seed = 20261124;
    of_run.run = run;
    const auto result = score::run(composition, of_run);
    REQUIRE(result.failures.empty());
    const auto& ins = result.summary.at("filters").at("ins");
    for (const char* block : {"position", "velocity", "clock", "offsets"}) {
      const auto& of_block = ins.at("consistency").at(block);
      REQUIRE(of_block.at("n") == 1);
      nees[block] += of_block.at("nees_mean").get<double>() / runs;
      dof[block] = of_block.at("dof").get<double>();
    }
    const auto& gnss = ins.at("measurements").at("gnss");
    REQUIRE(gnss.at("accepted") == gnss.at("offered"));
    const double count = gnss.at("accepted").get<double>();
    nis += gnss.at("nis_mean").get<double>() * count;
    rows += gnss.at("dof").get<double>() * count;
    samples += count;
  }
  std::printf("%s: mean NEES of four blocks at 150 s over %d runs, mean NIS over all epochs\n", title, runs);
  Found found;
  for (const auto& [block, mean] : nees) found.outside += !is_chi_square(mean, dof[block], runs, 1 - 0.01 / 4);
  found.nis_is_inside = is_chi_square(nis / samples, rows / samples, samples, 0.99);
  return found;
}

}  // namespace

TEST_CASE("NEES and NIS with given satellites of three systems") {
  const Found found = monte_carlo("given satellites", {});
  CHECK(found.outside == 0);
  CHECK(found.nis_is_inside);
}

TEST_CASE("a filter that takes the systems for one is found out") {
  // It knows an offset of 5 cm where there are 30 m.
  const Found found = monte_carlo("offsets not known", {"/filters/ins/blocks/offsets/sigma=0.05"});
  CHECK(found.outside >= 2);
  CHECK_FALSE(found.nis_is_inside);
}

}  // namespace given_test
