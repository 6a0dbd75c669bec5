// SPDX-License-Identifier: Apache-2.0
// No allocation in the run loop, neither by operator new nor by malloc, which Eigen calls.
#include <Eigen/Dense>

#include "allocations.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"
#include "skip.hpp"

namespace allocation_test {

using binnacle::conform::allocations;
using namespace binnacle;

namespace {

bool are_counted() {
  if (conform::allocations_are_counted()) return true;
  test::skip("with this C library allocations can not be counted");
  return false;
}

}  // namespace

TEST_CASE("a temporary of Eigen's is an allocation that is counted") {
  if (!are_counted()) return;
  const Eigen::Index size = 20 + static_cast<Eigen::Index>(allocations() % 2);  // not known when this is compiled
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(size, size), B(size, size);
  auto before = allocations();
  B.noalias() = A + A;
  REQUIRE(allocations() == before);
  before = allocations();
  A = A * A;  // by way of a temporary
  REQUIRE(allocations() > before);
  before = allocations();
  ::operator delete(::operator new(static_cast<std::size_t>(size)));
  REQUIRE(allocations() > before);
}

TEST_CASE("a temporary of Eigen's in a plugin's call shows up in the run loop") {
  if (!are_counted()) return;
  LoadOptions options;
  options.sets = {"/plugins=[]", "/plugins/-=" PROBE_PLUGIN};
  for (const bool allocates : {false, true}) {
    options.sets.push_back(std::string("/filters/f/measurements/see/noise/temporaries=") +
                           (allocates ? "true" : "false"));
    Session session(Composition::parse(R"({"binnacle": 1,
      "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
      "filters": {"f": {
        "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "sigma": 1}},
        "process": {"keep": {"type": "random_constant", "blocks": {"x": "x"}}},
        "measurements": {"see": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [1],
                                 "noise": {"type": "counting"}}}}}})",
                                       "test.json", options));
    const auto channel = session.channel("z");
    const double z[] = {0.5};
    session.push(channel, no_time, 0, z);
    const auto before = allocations();
    for (Time s = 1; s <= 10; ++s) session.push(channel, no_time, s * 1'000'000'000, z);
    const auto after = allocations();
    REQUIRE(session.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::accepted)] >= 10);
    REQUIRE((after - before >= 10) == allocates);
    REQUIRE((after == before) == !allocates);
  }
}

TEST_CASE("pushing samples allocates nothing, whatever becomes of them, in each form of P") {
  if (!are_counted()) return;
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  const std::string form = GENERATE("joseph", "ud", "square_root");
  CAPTURE(form);
  LoadOptions options;
  options.sets = {"/filters/ins/covariance=" + form};
  Session filter(Composition::load(BINNACLE_TEST_PROJECT "/tests/filter/ins.json", options));
  const auto imu = filter.channel("imu"), gnss = filter.channel("gnss");
  const auto position = filter.block("ins/position");
  const double still[] = {0, 0, 0, 0, 0, -0.0981};
  double fix[] = {0.8377580409572782, 0.19198621771937624, 500};
  constexpr Time ms = 1'000'000;
  const auto second = [&](Time from) {
    for (Time t = from; t < from + 1000 * ms; t += 10 * ms) {
      if (t % (200 * ms) == 0) filter.push(gnss, no_time, t + 4 * ms, fix);  // ahead, splits a sample
      filter.push(imu, t, t + 10 * ms, still);
    }
    double outputs[3], sigmas[3];
    filter.read(position, outputs);
    filter.read_sigma(position, sigmas);
  };
  const auto faults = [&](Time t) {
    filter.push(gnss, no_time, t - 500 * ms, fix);  // late
    fix[2] = 1e6;
    filter.push(gnss, no_time, t, fix);  // gated
    fix[2] = 500;
  };
  second(0);
  const auto before = allocations();
  for (Time s = 1; s < 20; ++s) {
    second(s * 1000 * ms);
    faults((s + 1) * 1000 * ms);
  }
  REQUIRE(allocations() == before);
  const auto counts = filter.counts({{0}, 0});
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::late)] == 19);
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::gated)] == 19);
  REQUIRE(counts.before_start == 1);
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::accepted)] == 99);
}

TEST_CASE("a gate by key allocates nothing, with outliers to find and without, in each form of P") {
  if (!are_counted()) return;
  const std::string form = GENERATE("joseph", "ud", "square_root");
  Session filter = filter_tests::session_of(filter_tests::with_form(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "max_rows": 8, "fields": {
      "key": {"unit": "1", "per_row": true}, "z": {"unit": "1", "per_row": true},
      "slope": {"unit": "1", "per_row": true}, "variance": {"unit": "1", "per_row": true}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 2, "unit": "1", "sigma": 10}},
      "process": {"keep": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"see": {"channel": "z", "gate": {"probability": 0.999, "by": "key"},
        "stack": {"first": {"type": "rows", "blocks": {"x": "x"}}, "second": {"type": "rows", "blocks": {"x": "x"}}}}}}}})",
                                                                    form));
  const auto channel = filter.channel("z");
  double rows[6][4] = {{1, 5, 0.1, 1}, {2, 5, -0.2, 1}, {3, 5, 0.3, 1},
                       {4, 5, 0.4, 1}, {5, 5, -0.5, 1}, {6, 5, 0.6, 1}};
  const auto offer = [&](Time t) {
    SampleView sample;
    sample.t = t;
    sample.rows = 6;
    sample.row_fields = &rows[0][0];
    filter.push(channel, sample);
  };
  offer(0);
  const auto before = allocations();
  for (Time s = 1; s < 50; ++s) {
    rows[3][1] = s % 3 == 0 ? 500.0 : 5.0;
    rows[1][1] = s % 6 == 0 ? -500.0 : 5.0;
    offer(s * 1'000'000'000);
  }
  REQUIRE(allocations() == before);
  REQUIRE(filter.counts({{0}, 0}).rows_left_out == 2 * (16 + 8));
}

}  // namespace allocation_test
