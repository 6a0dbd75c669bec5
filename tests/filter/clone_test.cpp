// SPDX-License-Identifier: Apache-2.0
// Stochastic cloning in a filter: equal to a solution over all states at once, exact in its instants, and P singular.
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace clone_test {

using namespace binnacle;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double q = 0.4, fix_sigma = 0.7, way_sigma = 0.05, first = 1, first_sigma = 2;

/// A position that wanders, fixes, and ways from one sample of `way` to the next.
std::string wanderer(const std::string& keys = "", const std::string& copy = R"("sigma": 5)") {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}},
                "way": {"type": "pushed", "fields": {"dx": {"unit": "m", "kind": "increment"}}}},
    "filters": {"f": {)" +
         keys + R"("blocks": {
        "x": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2},
        "then": {"type": "vector", "size": 1, "unit": "m", "init": 40, )" +
         copy + R"(},
        "age": {"type": "vector", "size": 1, "unit": "s", "estimate": []}},
      "process": {
        "walk": {"type": "random_walk", "blocks": {"x": "x"}, "q": 0.4},
        "copy": {"type": "clone", "inputs": {"at": "way"}, "blocks": {"of": "x", "copy": "then", "age": "age"}}},
      "measurements": {
        "fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [0.7]},
        "way": {"type": "relative_position", "channel": "way", "frame": "navigation", "sigma": [0.05, 0.05, 0.05],
                "blocks": {"position": "x", "copy": "then", "age": "age"}}}}}})";
}

/// x at all instants at once: prior, steps and measurements as one least squares problem.
class Batch {
 public:
  explicit Batch(double t) : times_{t} { add({{0, 1.0}}, first, first_sigma); }

  void fix(double t, double z) { add({{at(t), 1.0}}, z, fix_sigma); }
  void way(double t0, double t, double z) {
    const int then = at(t0);
    add({{at(t), 1.0}, {then, -1.0}}, z, way_sigma);
  }
  /// Mean and variance of x at the last instant.
  std::pair<double, double> last() const {
    const int n = static_cast<int>(times_.size());
    MatrixXd information = MatrixXd::Zero(n, n);
    VectorXd sums = VectorXd::Zero(n);
    for (const Row& row : rows_)
      for (const auto& [i, a] : row.of) {
        sums[i] += a * row.z / row.variance;
        for (const auto& [j, b] : row.of) information(i, j) += a * b / row.variance;
      }
    const MatrixXd P = information.inverse();
    return {(P * sums)[n - 1], P(n - 1, n - 1)};
  }

 private:
  struct Row {
    std::vector<std::pair<int, double>> of;
    double z, variance;
  };
  void add(std::vector<std::pair<int, double>> of, double z, double sigma) {
    rows_.push_back({std::move(of), z, sigma * sigma});
  }
  /// Instants come in order.
  int at(double t) {
    for (std::size_t i = 0; i < times_.size(); ++i)
      if (times_[i] == t) return static_cast<int>(i);
    times_.push_back(t);
    const int n = static_cast<int>(times_.size());
    add({{n - 1, 1.0}, {n - 2, -1.0}}, 0, q * std::sqrt(t - times_[times_.size() - 2]));
    return n - 1;
  }

  std::vector<double> times_;
  std::vector<Row> rows_;
};

void push_way(Session& filter, double t0, double t, double dx) {
  filter.push(filter.channel("way"), nanoseconds(t0), nanoseconds(t), {&dx, 1});
}

double x_of(const Session& filter) { return filter.state(FilterId{0})[0]; }
double variance_of(const Session& filter) { return filter.covariance(FilterId{0})(0, 0); }

std::int64_t count(const Session& filter, const char* measurement, Outcome outcome) {
  return filter.counts(filter.measurement(measurement)).by_outcome[static_cast<int>(outcome)];
}

/// A position that is carried by speeds, a copy of it, and ways from there.
const char* const carried_and_copied = R"({"binnacle": 1,
    "sources": {"go": {"type": "pushed", "fields": {"v": {"unit": "m/s", "kind": "rate"}}},
                "way": {"type": "pushed", "fields": {"dx": {"unit": "m", "kind": "increment"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2},
                 "then": {"type": "vector", "size": 1, "unit": "m", "sigma": 5},
                 "age": {"type": "vector", "size": 1, "unit": "s", "estimate": []}},
      "process": {"go": {"type": "carried", "input": "go", "blocks": {"x": "x"}},
                  "copy": {"type": "clone", "inputs": {"at": "way"}, "blocks": {"of": "x", "copy": "then", "age": "age"}}},
      "measurements": {"way": {"type": "relative_position", "channel": "way", "frame": "navigation", "sigma": [0.05, 1, 1],
                               "blocks": {"position": "x", "copy": "then", "age": "age"}}}}}})";

}  // namespace

TEST_CASE("clone: a filter with copies is the least squares solution over all instants") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  auto session = filter_tests::session_of(wanderer());
  filter_tests::push(session, "z", 0, {1.3});
  Batch batch(0);
  batch.fix(0, 1.3);
  double then = 0;
  for (int k = 1; k <= 200; ++k) {
    const double t = 0.25 * k;
    // Ways of one, two or three quarters of a second; fixes between and at their ends, and long without any.
    if (k % 3 == 0 || k % 7 == 0) {
      const double dx = 0.3 * normal(random);
      push_way(session, then, t, dx);
      batch.way(then, t, dx);
      then = t;
    }
    if (k % 2 == 0 && k % 50 < 25) {
      const double z = 2 * normal(random);
      filter_tests::push(session, "z", t, {z});
      batch.fix(t, z);
    }
    if (session.time(FilterId{0}) != nanoseconds(t)) continue;
    const auto [mean, variance] = batch.last();
    CAPTURE(t, x_of(session), mean, variance_of(session), variance);
    REQUIRE(std::abs(x_of(session) - mean) < 1e-10 * std::sqrt(variance));
    REQUIRE(std::abs(variance_of(session) / variance - 1) < 1e-10);
  }
  REQUIRE(count(session, "way", Outcome::accepted) == 200 / 3 + 200 / 7 - 200 / 21);
}

TEST_CASE("clone: who takes the begin of each way as known believes too much") {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  auto cloned = filter_tests::session_of(wanderer());
  auto naive = filter_tests::session_of(wanderer("", R"("estimate": [])"));
  for (auto* session : {&cloned, &naive}) filter_tests::push(*session, "z", 0, {1.0});
  for (int k = 1; k <= 50; ++k) {
    const double dx = 0.3 * normal(random);
    for (auto* session : {&cloned, &naive}) push_way(*session, k - 1, k, dx);
  }
  // 50 ways of 5 cm each, on a fix: σ² = (2⁻² + 0.7⁻²)⁻¹ + 50 · 0.05² q²/(q² + 0.05²)
  const double r = way_sigma * way_sigma * q * q / (q * q + way_sigma * way_sigma);
  CHECK(std::abs(variance_of(cloned) / (1 / (0.25 + 1 / 0.49) + 50 * r) - 1) < 1e-9);
  CHECK(variance_of(naive) < 1.01 * r);
}

TEST_CASE("clone: after the step that copies, P has not its full rank, and the filter goes on") {
  auto session = filter_tests::session_of(carried_and_copied);
  const double v = 3;
  const auto go = [&](double from, double to) {
    session.push(session.channel("go"), nanoseconds(from), nanoseconds(to), {&v, 1});
  };
  const auto P = [&] { return MatrixXd(session.covariance(FilterId{0}).as()); };
  const auto state = [&](int i) { return session.state(FilterId{0})[static_cast<std::size_t>(i)]; };
  go(0, 0.1);
  // `carried` has no noise: position and copy have one and the same error.
  CHECK(P() == 4 * MatrixXd::Ones(2, 2));
  CHECK(state(1) == 1);
  CHECK(state(2) == 0.1);
  // Within a sample of the input: the copy is of that very instant.
  push_way(session, 0, 0.13, 0.39);
  go(0.1, 0.2);
  CHECK(session.healthy(FilterId{0}));
  CHECK(count(session, "way", Outcome::accepted) == 1);
  CHECK(std::abs(state(1) - 1.39) < 1e-12);
  CHECK(state(2) == 0.07);
  CHECK(std::abs(P().determinant()) < 1e-14);
  push_way(session, 0.13, 0.2, 0.21 + 0.1);  // it cannot say anything: both have the same error
  CHECK(count(session, "way", Outcome::accepted) == 2);
  CHECK(std::abs(state(0) - 1.6) < 1e-12);
  CHECK(P().isApprox(4 * MatrixXd::Ones(2, 2)));
  // A hole of the input is bridged with noise: then the way does.
  go(0.5, 0.6);
  CHECK(P()(0, 0) > 7.9);
  CHECK(P().determinant() > 15);
  CHECK(state(2) == 0.4);
  push_way(session, 0.2, 0.6, 1.2 + 0.5);
  CHECK(count(session, "way", Outcome::accepted) == 3);
  CHECK(std::abs(state(0) - (1.6 + 1.2 + 0.5)) < 0.01);
}

TEST_CASE("clone: a way that begins at another instant than the copy's is not used, and says why") {
  auto session = filter_tests::session_of(wanderer());
  filter_tests::push(session, "z", 10, {1});
  push_way(session, 10, 11, 0.1);
  push_way(session, 11, 12, 0.1);
  CHECK(count(session, "way", Outcome::accepted) == 2);
  push_way(session, 11.5, 13, 0.1);
  CHECK(count(session, "way", Outcome::unsupported) == 1);
  CHECK(session.counts(session.measurement("way")).last_reason ==
        "its interval begins at another instant than that of the copy");
  // It was a sample all the same: the copy is of 13.
  push_way(session, 13, 14, 0.1);
  CHECK(count(session, "way", Outcome::accepted) == 3);
  // One that is lost takes the next with it, and no more.
  push_way(session, 15, 16, 0.1);
  CHECK(count(session, "way", Outcome::unsupported) == 2);
  push_way(session, 16, 17, 0.1);
  CHECK(count(session, "way", Outcome::accepted) == 4);
}

TEST_CASE("clone: at the start nothing has been copied") {
  // The way ends where the filter starts; age and copy are what the config says, and the age does not fit.
  auto session = filter_tests::session_of(wanderer());
  push_way(session, 0, 1, 0.1);
  CHECK(count(session, "way", Outcome::unsupported) == 1);
  CHECK(variance_of(session) == 4);
}

TEST_CASE("clone: with a copy of its bytes a session goes on to the bit, also between sample and copy") {
  const auto composition = filter_tests::composition_of(wanderer());
  Session all(composition), half(composition);
  const auto drive = [](Session& session, int from, int to) {
    for (int k = from; k < to; ++k) {
      if (k % 2 == 0) push_way(session, 0.5 * k - 1, 0.5 * k, 0.1 * k);
      filter_tests::push(session, "z", 0.5 * k + 0.25, {0.2 * k});
    }
  };
  for (auto* session : {&all, &half}) filter_tests::push(*session, "z", 0, {1});
  drive(all, 1, 40);
  drive(half, 1, 20);
  push_way(half, 9, 10, 2.0);
  std::vector<std::byte> bytes(half.snapshot_size());
  half.snapshot(bytes);
  Session again(composition);
  again.restore(bytes);
  filter_tests::push(again, "z", 10.25, {4.0});
  drive(again, 21, 40);
  CHECK(x_of(again) == x_of(all));
  CHECK(variance_of(again) == variance_of(all));
  CHECK(count(again, "way", Outcome::accepted) == count(all, "way", Outcome::accepted));
  CHECK(count(again, "way", Outcome::unsupported) == 0);
}

TEST_CASE("clone: a way that comes late, within the history, is used as if it had been in time") {
  const auto composition = filter_tests::composition_of(wanderer(R"("history": "2 s", )"));
  Session ordered(composition), late(composition);
  for (auto* session : {&ordered, &late}) filter_tests::push(*session, "z", 0, {1});
  for (int k = 1; k <= 20; ++k) {
    push_way(ordered, k - 1, k, 0.1 * k);
    filter_tests::push(ordered, "z", k + 0.5, {0.2 * k});
    if (k > 1) filter_tests::push(late, "z", k - 0.5, {0.2 * (k - 1)});
    push_way(late, k - 1, k, 0.1 * k);  // behind the fix half a second later of the round before
  }
  filter_tests::push(late, "z", 20.5, {4.0});
  CHECK(x_of(ordered) == x_of(late));
  Session shuffled(composition);
  filter_tests::push(shuffled, "z", 0, {1});
  for (int k = 1; k <= 20; ++k) {
    filter_tests::push(shuffled, "z", k + 0.5, {0.2 * k});
    push_way(shuffled, k - 1, k, 0.1 * k);  // half a second late
  }
  CHECK(count(shuffled, "way", Outcome::accepted) == 20);
  CHECK(x_of(ordered) == x_of(shuffled));
  CHECK(variance_of(ordered) == variance_of(shuffled));
}

TEST_CASE("clone: of ways that all wait for the input, those are used whose begin was kept") {
  auto session = filter_tests::session_of(carried_and_copied);
  const double v = 1;
  const auto go = [&](double from, double to) {
    session.push(session.channel("go"), nanoseconds(from), nanoseconds(to), {&v, 1});
  };
  go(0, 0.1);
  // Each is seen in a step before the next one comes.
  push_way(session, 0, 0.25, 0.25);
  go(0.1, 0.2);
  push_way(session, 0.25, 0.35, 0.1);
  go(0.2, 0.3);
  push_way(session, 0.35, 0.45, 0.1);
  go(0.3, 0.4);
  go(0.4, 0.5);
  CHECK(count(session, "way", Outcome::accepted) == 3);
  // Of three at once the newest two can be: the end of the first was never seen, the begin of the last is that of the second's end.
  push_way(session, 0.45, 0.55, 0.1);
  push_way(session, 0.55, 0.65, 0.1);
  push_way(session, 0.65, 0.75, 0.1);
  go(0.5, 0.6);
  go(0.6, 0.7);
  go(0.7, 0.8);
  CHECK(count(session, "way", Outcome::accepted) == 5);
  CHECK(count(session, "way", Outcome::unsupported) == 1);
}

}  // namespace clone_test
