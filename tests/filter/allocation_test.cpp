// SPDX-License-Identifier: Apache-2.0
// No allocation in the run loop: counted by replacing operator new for this program.
#include <atomic>
#include <cstdlib>
#include <new>

#include "binnacle/session.hpp"
#include "catch.hpp"

namespace {
std::atomic<long> allocations{0};
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }

using namespace binnacle;

TEST_CASE("pushing samples allocates nothing, whatever becomes of them") {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  Session filter(Composition::load(BINNACLE_TEST_PROJECT "/tests/filter/ins.json"));
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
  const long before = allocations;
  for (Time s = 1; s < 20; ++s) {
    second(s * 1000 * ms);
    faults((s + 1) * 1000 * ms);
  }
  REQUIRE(allocations - before == 0);
  const auto counts = filter.counts({{0}, 0});
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::late)] == 19);
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::gated)] == 19);
  REQUIRE(counts.before_start == 1);
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::accepted)] == 99);
}

TEST_CASE("a gate by key allocates nothing, with outliers to find and without") {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = {"/plugins=[]", "/plugins/-=" PROBE_PLUGIN};
  Session filter(Composition::parse(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "max_rows": 8, "fields": {
      "key": {"unit": "1", "per_row": true}, "z": {"unit": "1", "per_row": true},
      "slope": {"unit": "1", "per_row": true}, "variance": {"unit": "1", "per_row": true}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 2, "unit": "1", "sigma": 10}},
      "process": {"keep": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"see": {"channel": "z", "gate": {"probability": 0.999, "by": "key"},
        "stack": {"first": {"type": "rows", "blocks": {"x": "x"}}, "second": {"type": "rows", "blocks": {"x": "x"}}}}}}}})",
                                    "test.json", options));
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
  const long before = allocations;
  for (Time s = 1; s < 50; ++s) {
    rows[3][1] = s % 3 == 0 ? 500.0 : 5.0;
    rows[1][1] = s % 6 == 0 ? -500.0 : 5.0;
    offer(s * 1'000'000'000);
  }
  REQUIRE(allocations - before == 0);
  REQUIRE(filter.counts({{0}, 0}).rows_left_out == 2 * (16 + 8));
}
