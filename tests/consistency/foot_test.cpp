// SPDX-License-Identifier: Apache-2.0
// configs/foot: a walk by zero-velocity updates over many runs. The filter is never overconfident, finds the tilt, and does not
// believe to know the heading, which such updates cannot observe.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include <boost/math/distributions/chi_squared.hpp>

#include "catch.hpp"
#include "score/run.hpp"

namespace foot_test {

using namespace binnacle;

namespace {

constexpr int runs = 20;
constexpr double degree = M_PI / 180;

std::shared_ptr<const Composition> load(std::vector<std::string> sets) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = std::move(sets);
  options.sets.push_back("/sources/walk/repeat=1");
  return score::load(BINNACLE_TEST_PROJECT "/configs/foot/walk.json", options);
}

/// Of each run, the metrics.
std::vector<std::vector<double>> figures(const std::shared_ptr<const Composition>& composition,
                                         const std::vector<std::string>& names, int count) {
  score::RunOptions options;
  for (const auto& name : names) {
    const auto metric = score::read_metric(*composition, name);
    INFO(name);
    REQUIRE(metric);
    options.metrics.push_back(*metric);
  }
  std::vector<std::vector<double>> all;
  for (int run = 0; run < count; ++run) {
    options.run = run;
    const auto result = score::run(composition, options);
    REQUIRE(result.failures.empty());
    std::vector<double> values;
    for (const auto& value : result.metrics) values.push_back(value.value);
    all.push_back(values);
  }
  return all;
}

double mean(const std::vector<std::vector<double>>& all, std::size_t metric) {
  double sum = 0;
  for (const auto& one : all) sum += one[metric];
  return sum / static_cast<double>(all.size());
}

double upper(int dof) {
  return boost::math::quantile(boost::math::complement(boost::math::chi_squared(dof * runs), 0.005)) / runs;
}
double lower(int dof) { return boost::math::quantile(boost::math::chi_squared(dof * runs), 0.005) / runs; }

}  // namespace

TEST_CASE("a walk by zero-velocity updates: consistent in what they do not see, never overconfident in what they do") {
  const auto composition = load({});
  const auto all = figures(composition,
                           {"ins/attitude.down/nees at 150 s", "ins/position/nees at 150 s",
                            "ins/attitude/nees at 150 s", "ins/attitude.down/sigma", "ins/attitude.north/sigma",
                            "ins/position.horizontal/final", "ins/gyro_bias/nees at 150 s"},
                           runs);
  std::printf(
      "foot: NEES heading %.2f, position %.2f, attitude %.2f, gyro bias %.2f; sigma of heading %.2f deg, of tilt %.4f "
      "deg, "
      "horizontal %.2f m\n",
      mean(all, 0), mean(all, 1), mean(all, 2), mean(all, 6), mean(all, 3) / degree, mean(all, 4) / degree,
      mean(all, 5));
  // Zero velocity says nothing of the heading, so nothing of R, which is too large here, is in it.
  CHECK((mean(all, 0) > lower(1) && mean(all, 0) < upper(1)));
  CHECK(mean(all, 1) < upper(3));
  CHECK(mean(all, 2) < upper(3));
  CHECK(mean(all, 6) < upper(3));
  CHECK(mean(all, 3) > 1.0 * degree);   // that of the start
  CHECK(mean(all, 4) < 0.05 * degree);  // half a degree at the start
  CHECK(mean(all, 5) < 2.0);            // of 190 m
}

TEST_CASE("a walk without zero-velocity updates is lost within a lap") {
  const auto composition = load({"/filters/ins/measurements=null"});
  CHECK(mean(figures(composition, {"ins/position.horizontal/final"}, 3), 0) > 100);
}

}  // namespace foot_test
