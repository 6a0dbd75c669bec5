// SPDX-License-Identifier: Apache-2.0
// Filters that are right are never noted as conservative, whatever their gate; those that are far from it always.
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "catch.hpp"
#include "conservative.hpp"
#include "score/run.hpp"

namespace conservative_test {

using namespace binnacle;

namespace {

/// In how many runs of matched.json, so set, there is a note.
int noted(std::vector<std::string> sets, int runs) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = std::move(sets);
  const auto composition = score::load(BINNACLE_TEST_PROJECT "/tests/consistency/matched.json", options);
  int count = 0;
  for (int run = 0; run < runs; ++run) {
    const auto verdict = score::run(composition, {20261126, run}).summary["filters"]["ins"]["verdict"];
    if (!verdict.contains("notes")) continue;
    CHECK(verdict["notes"][0]["likely"] == "sigma");
    ++count;
  }
  return count;
}

std::vector<std::string> fix_scale(double factor) {
  const std::string stack = "/filters/ins/measurements/fix/stack/", scale = "/scale=" + std::to_string(factor);
  return {stack + "position" + scale, stack + "velocity" + scale};
}

}  // namespace

TEST_CASE("no filter whose model is the truth is noted as conservative") {
  CHECK(noted({}, 60) == 0);
  const std::string fix = "/filters/ins/measurements/fix/";
  CHECK(noted({fix + R"(gate={"probability": 0.5, "by": "row"})", fix + "recover=false"}, 20) == 0);
}

TEST_CASE("a filter whose fixes are twice as precise as specified is noted in each run") {
  CHECK(noted(fix_scale(2), 20) == 20);
}

TEST_CASE("a gate's share of a row's variance is that of the normal distribution cut off") {
  CHECK(score::share_inside_gate(0) == 1);
  for (const double limit : {0.5, 1.0, 2.0, 3.0}) {
    double inside = 0, variance = 0;
    constexpr int steps = 20000;
    for (int i = 0; i < steps; ++i) {
      const double z = limit * (i + 0.5) / steps, density = std::exp(-z * z / 2);
      inside += density;
      variance += z * z * density;
    }
    CAPTURE(limit);
    CHECK(std::abs(score::share_inside_gate(std::erf(limit / std::sqrt(2.0))) - variance / inside) < 1e-6);
  }
}

}  // namespace conservative_test
