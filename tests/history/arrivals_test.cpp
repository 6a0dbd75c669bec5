// SPDX-License-Identifier: Apache-2.0
// Latencies that a config draws: each distribution against its own moments.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "catch.hpp"
#include "line.hpp"
#include "run/arrivals.hpp"

namespace arrivals_test {

using namespace binnacle;

namespace {

constexpr int count = 20000;

/// From samples to their arrivals [s], of a source with this latency. Each sample arrives before the next is read.
std::vector<double> delays(const std::string& latency) {
  LoadOptions options;
  options.sets = {"/sources/drive/latency=" + latency};
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  const auto composition = Composition::load(BINNACLE_TEST_PROJECT "/configs/quickstart.json", options);
  const auto& plan = composition->plan();
  REQUIRE(plan.sources.size() == 1);
  internal::runtime::Arrivals arrivals(plan);
  arrivals.reset(1, 0);
  const std::vector<double> fields(100);
  std::vector<double> delays;
  for (int i = 0; i < count; ++i) {
    SampleView sample;
    sample.t = 10 * i * nanoseconds_per_second + 1;
    sample.fields = sample.row_fields = fields.data();
    arrivals.read(0, plan.sources[0].channels[0], sample);
    delays.push_back(seconds(arrivals.next() - sample.t));
    arrivals.take_instant([](int, const SampleView&, std::int64_t) {});
  }
  REQUIRE(arrivals.empty());
  return delays;
}

double mean_of(const std::vector<double>& values, double about = 0, int power = 1) {
  double sum = 0;
  for (const double value : values) sum += std::pow(value - about, power);
  return sum / static_cast<double>(values.size());
}

/// Mean, variance and third central moment, within five of their own standard deviations; neighbours are uncorrelated.
void has_moments(const std::vector<double>& values, double mean, double variance, double third, double fourth,
                 double sixth) {
  const double n = count, sigma = std::sqrt(variance);
  CHECK(std::abs(mean_of(values) - mean) < 5 * sigma / std::sqrt(n));
  CHECK(std::abs(mean_of(values, mean, 2) - variance) < 5 * std::sqrt((fourth - variance * variance) / n));
  CHECK(std::abs(mean_of(values, mean, 3) - third) < 5 * std::sqrt((sixth - third * third) / n));
  std::vector<double> products;
  for (std::size_t i = 1; i < values.size(); ++i) products.push_back((values[i] - mean) * (values[i - 1] - mean));
  CHECK(std::abs(mean_of(products)) < 5 * variance / std::sqrt(n));
}

}  // namespace

TEST_CASE("arrivals: a normal latency has its mean and deviation, and no correlation") {
  const double variance = 0.01;
  has_moments(delays(R"({"normal": {"mean": "1 s", "sigma": "0.1 s"}})"), 1, variance, 0, 3 * std::pow(variance, 2),
              15 * std::pow(variance, 3));
}

TEST_CASE("arrivals: an exponential latency has the moments of its distribution") {
  const double mean = 0.3;
  has_moments(delays(R"({"exponential": "0.3 s"})"), mean, mean * mean, 2 * std::pow(mean, 3), 9 * std::pow(mean, 4),
              265 * std::pow(mean, 6));
}

TEST_CASE("arrivals: a uniform latency fills its range, and nothing else") {
  const auto values = delays(R"({"uniform": ["0.2 s", "0.8 s"]})");
  const double variance = 0.6 * 0.6 / 12;
  has_moments(values, 0.5, variance, 0, 9.0 / 5 * std::pow(variance, 2), 27.0 / 7 * std::pow(variance, 3));
  CHECK(std::ranges::min(values) >= 0.2 - 1e-9);
  CHECK(std::ranges::max(values) <= 0.8 + 1e-9);
}

TEST_CASE("arrivals: a batch arrives at multiples of its period") {
  for (const double value : delays(R"({"batch": "4 s"})")) {
    CAPTURE(value);
    REQUIRE(std::abs(std::remainder(value, 2)) < 1e-8);
    REQUIRE((value > 1 && value <= 4));
  }
}

}  // namespace arrivals_test
