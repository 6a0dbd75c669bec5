// SPDX-License-Identifier: Apache-2.0
// Session's calls are checked: ids, sizes of spans, times; what is refused changes nothing.
#include "binnacle/session.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"

namespace session_test {

using namespace binnacle;

namespace {

constexpr Time second = 1'000'000'000;

Session session_of() {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  return Session(Composition::parse(R"({"binnacle": 1,
    "sources": {"rate": {"type": "pushed", "fields": {"dx": {"unit": "m/s", "kind": "rate"}}},
                "z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 2, "unit": "m", "sigma": 1}},
      "process": {"p": {"type": "random_walk", "blocks": {"x": "x"}, "q": 0.1}},
      "measurements": {
        "fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [1], "H": [[1, 0]]}}}}})",
                                    "test.json"));
}

const double one[] = {0.5};

}  // namespace

TEST_CASE("names give ids, and a wrong one the nearest name") {
  Session session = session_of();
  CHECK(session.channel("z").index == 1);
  CHECK(session.filter("f").index == 0);
  CHECK(session.block("f/x").index == 0);
  CHECK(session.measurement("f/fix").index == 0);
  CHECK(session.measurement("fix").filter.index == 0);
  const auto refusal = [&](const char* name) -> std::string {
    try {
      session.measurement(name);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  CHECK(refusal("f/fxi").ends_with("there is no measurement 'f/fxi'; did you mean 'f/fix'?"));
  CHECK(refusal("fxi").ends_with("there is no measurement 'fxi'; did you mean 'fix'?"));
  CHECK_THROWS_AS(session.channel("zz"), ConfigError);
}

TEST_CASE("an id that the composition does not have is out of range, in every call") {
  Session session = session_of();
  double values[2];
  for (const int wrong : {-1, 1, 1000}) {
    const FilterId filter{wrong};
    CHECK_THROWS_AS(session.started(filter), std::out_of_range);
    CHECK_THROWS_AS(session.healthy(filter), std::out_of_range);
    CHECK_THROWS_AS(session.diagnosis(filter), std::out_of_range);
    CHECK_THROWS_AS(session.time(filter), std::out_of_range);
    CHECK_THROWS_AS(session.start_time(filter), std::out_of_range);
    CHECK_THROWS_AS(session.state(filter), std::out_of_range);
    CHECK_THROWS_AS(session.covariance(filter), std::out_of_range);
    CHECK_THROWS_AS(session.attach(filter, nullptr), std::out_of_range);
    for (const BlockId block : {BlockId{filter, 0}, BlockId{{0}, wrong}}) {
      CHECK_THROWS_AS(session.read(block, values), std::out_of_range);
      CHECK_THROWS_AS(session.read_sigma(block, values), std::out_of_range);
      CHECK_THROWS_AS(session.covariance(block), std::out_of_range);
    }
    for (const MeasurementId measurement : {MeasurementId{filter, 0}, MeasurementId{{0}, wrong}})
      CHECK_THROWS_AS(session.counts(measurement), std::out_of_range);
  }
  for (const int wrong : {-1, 3, 1000}) {  // rate, z, and the filter's own
    CHECK_THROWS_AS(session.counts(ChannelId{wrong}), std::out_of_range);
    CHECK_THROWS_AS(session.push(ChannelId{wrong}, no_time, second, one), std::out_of_range);
  }
}

TEST_CASE("a span of another size than the block's outputs is refused and not written to") {
  Session session = session_of();
  session.push(session.channel("z"), no_time, second, one);
  const BlockId x = session.block("x");
  std::vector<double> values(4, 7.0);
  for (const std::size_t size : std::vector<std::size_t>{0, 1, 3, 4}) {
    CHECK_THROWS_AS(session.read(x, {values.data(), size}), std::invalid_argument);
    CHECK_THROWS_AS(session.read_sigma(x, {values.data(), size}), std::invalid_argument);
  }
  CHECK(values == std::vector<double>(4, 7.0));
  session.read(x, {values.data(), 2});
  session.read_sigma(x, {values.data() + 2, 2});
  CHECK(std::abs(values[0] - 0.25) < 1e-12);  // half way: both variances are 1
  CHECK(std::abs(values[2] - std::sqrt(0.5)) < 1e-7);
  CHECK(std::abs(values[3] - 1) < 1e-7);
}

TEST_CASE("before the start there is no estimate: NaN, not zeros") {
  Session session = session_of();
  const BlockId x = session.block("x");
  std::vector<double> values(4, 7.0);
  const auto read = [&] {
    session.read(x, {values.data(), 2});
    session.read_sigma(x, {values.data() + 2, 2});
    return std::ranges::count_if(values, [](double value) { return std::isnan(value); });
  };
  CHECK(read() == 4);
  session.push(session.channel("z"), no_time, second, one);
  CHECK(read() == 0);
  session.reset();
  CHECK(read() == 4);
}

TEST_CASE("an interval that does not end after it began is refused, and changes nothing") {
  Session session = session_of();
  const ChannelId rate = session.channel("rate"), z = session.channel("z");
  session.push(z, no_time, second, one);
  const Time before = session.time({0});
  CHECK_THROWS_AS(session.push(rate, 3 * second, 2 * second, one), std::invalid_argument);
  CHECK_THROWS_AS(session.push(rate, 2 * second, 2 * second, one), std::invalid_argument);
  CHECK_THROWS_AS(session.push(z, no_time, no_time, one), std::invalid_argument);
  const double two[] = {1, 2};
  CHECK_THROWS_AS(session.push(z, no_time, 2 * second, two), std::invalid_argument);
  CHECK_THROWS_AS(session.push(z, SampleView{.t = 2 * second, .available = true}), std::invalid_argument);  // no fields
  CHECK(session.time({0}) == before);
  CHECK(session.counts(rate).pushed == 0);
  CHECK(session.counts(z).pushed == 1);
  CHECK(session.counts(session.measurement("fix")).offered == 1);
}

TEST_CASE("a sample that is older than another before it on its channel is counted") {
  Session session = session_of();
  const ChannelId z = session.channel("z");
  for (const Time t : {1, 3, 2, 3, 4}) session.push(z, no_time, t * second, one);
  CHECK(session.counts(z).pushed == 5);
  CHECK(session.counts(z).behind == 1);
  CHECK(session.counts(session.measurement("fix")).by_outcome[static_cast<int>(Outcome::late)] == 1);
  session.reset();
  CHECK(session.counts(z).pushed == 0);
}

TEST_CASE("after a restored snapshot what was newer counts no more") {
  Session session = session_of();
  const ChannelId z = session.channel("z");
  session.push(z, no_time, second, one);
  std::vector<std::byte> bytes(session.snapshot_size());
  session.snapshot(bytes);
  session.push(z, no_time, 5 * second, one);
  session.restore(bytes);
  session.push(z, no_time, 2 * second, one);
  CHECK(session.counts(z).behind == 0);
}

TEST_CASE("samples of one instant have its time") {
  Session session = session_of();
  const ChannelId z = session.channel("z");
  SampleView sample;
  sample.t = second;
  sample.fields = one;
  session.add(z, sample);
  CHECK_THROWS_AS(session.commit(2 * second), std::invalid_argument);
  CHECK_THROWS_AS(session.push(z, no_time, 2 * second, one), std::invalid_argument);
  sample.t = 2 * second;
  CHECK_THROWS_AS(session.add(z, sample), std::invalid_argument);
  session.commit(second);
  CHECK(session.time({0}) == second);
  session.push(z, no_time, 2 * second, one);
  CHECK(session.time({0}) == 2 * second);
}

}  // namespace session_test
