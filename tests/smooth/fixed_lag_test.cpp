// SPDX-License-Identifier: Apache-2.0
// What a fixed-lag smoother emits is what a fixed-interval smoother gives over all data up to that sweep; in order, once,
// and without allocating once its log is as long as it gets.
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "allocations.hpp"
#include "binnacle/eigen.hpp"
#include "catch.hpp"
#include "line.hpp"
#include "skip.hpp"
#include "smooth/fixed_lag.hpp"
#include "smooth/interval_smoother.hpp"

namespace fixed_lag_test {

using namespace binnacle;
using filter_tests::composition_of;
using filter_tests::line;
using filter_tests::push;

namespace {

constexpr double period = 0.1;

struct Estimate {
  Time t;
  Eigen::Vector2d x;
  Eigen::Matrix2d P;
};

/// Outliers, gaps, two samples of an instant.
void push_sample(Session& session, int k) {
  std::mt19937 random(static_cast<unsigned>(k) + 1);
  const double noise = std::normal_distribution<double>()(random);
  if (k % 50 > 40) return;
  push(session, "z", period * k, {1 + 0.05 * k + 0.7 * noise + (k % 17 == 3 ? 40 : 0)});
  if (k % 5 == 0) push(session, "z", period * k, {1 + 0.05 * k - 0.5 * noise});
}

/// All estimates of a run of so many samples, smoothed over it.
std::vector<Estimate> smoothed_over(const std::shared_ptr<const Composition>& composition, int count) {
  Session session(composition);
  smooth::SmoothedFilter filter(session, 0);
  session.attach({0}, &filter.stretch());
  Time last = no_time;
  for (int k = 0; k < count; ++k) {
    push_sample(session, k);
    if (session.time({0}) != last) filter.mark();
    last = session.time({0});
  }
  std::vector<Estimate> all;
  filter.sweep(
      [&](const smooth::Epoch& epoch) {
        all.insert(all.begin(), {epoch.t, Eigen::Map<const Eigen::Vector2d>(epoch.x), epoch.P.as()});
      },
      [](smooth::WithheldSample) {});
  return all;
}

double difference(const Estimate& a, const Estimate& b) {
  return std::max((a.x - b.x).norm() / b.x.norm(), (a.P - b.P).norm() / b.P.norm());
}

}  // namespace

TEST_CASE("a fixed lag gives what the whole interval up to each sweep gives, in order and once") {
  constexpr int count = 200;
  for (const auto& [lag, every] :
       {std::pair(5.0, 1.0), std::pair(2.35, 0.7), std::pair(0.0, 1.0), std::pair(1.0, 3.0)}) {
    CAPTURE(lag, every);
    const auto composition = composition_of(line("", R"(, "gate": 0.9999, "recover": false)"));
    Session session(composition);
    std::vector<Estimate> emitted;
    std::vector<int> known;  // samples up to the sweep that emitted it
    int pushed = 0;
    smooth::FixedLag smoother(session, {0}, {nanoseconds(lag), nanoseconds(every)}, [&](const smooth::Epoch& epoch) {
      emitted.push_back({epoch.t, Eigen::Map<const Eigen::Vector2d>(epoch.x), epoch.P.as()});
      known.push_back(pushed);
    });
    session.attach({0}, &smoother);
    for (; pushed < count; ++pushed) push_sample(session, pushed);
    const std::size_t before_end = emitted.size();
    smoother.finish();
    const auto whole = smoothed_over(composition, count);
    REQUIRE(emitted.size() == whole.size());
    CHECK(before_end > 100);
    for (std::size_t k = 0; k < emitted.size(); ++k) {
      REQUIRE(emitted[k].t == whole[k].t);
      const auto interval = smoothed_over(composition, known[k]);
      REQUIRE(interval.size() > k);
      CHECK(difference(emitted[k], interval[k]) < 1e-10);
      // No younger than the lag, and by no more than a sweep, a step and a gap older.
      const double age = seconds(interval.back().t - emitted[k].t);
      if (k < before_end) CHECK(age >= lag - 1e-9);
      if (k < before_end) CHECK(age <= lag + every + 10 * period + 1e-9);
    }
  }
}

TEST_CASE(
    "a lag's channel, beside another observer: each sees every step, and what is pushed on the channel is its own") {
  struct Counter final : StepObserver {
    int steps = 0;
    void stepped(const StepRecord&) override { ++steps; }
  } counter;
  Session session(composition_of(line("")));
  // A section would give the filter such a channel.
  CHECK_THROWS_AS(session.push_estimates(session.channel("f"), {0}, 0, nullptr, {}), std::invalid_argument);
  int emitted = 0;
  smooth::FixedLag lag(session, {0}, {nanoseconds(1.0), nanoseconds(1.0)}, [&](const smooth::Epoch&) { ++emitted; });
  session.attach_section({0}, &lag);
  session.attach({0}, &counter);
  for (int k = 0; k < 100; ++k) push_sample(session, k);
  CHECK(counter.steps > 60);
  session.attach({0}, nullptr);
  const int before = counter.steps;
  for (int k = 100; k < 200; ++k) push_sample(session, k);
  CHECK(counter.steps == before);
  lag.finish();
  CHECK(emitted > 150);
}

TEST_CASE("a fixed lag allocates nothing once its log is as long as it gets") {
  if (!conform::allocations_are_counted()) return test::skip("with this C library allocations can not be counted");
  for (const std::string velocity_extra : {"", R"(, "consider": ["x"])"}) {
    Session session(composition_of(line("", "", velocity_extra)));
    int emitted = 0;
    smooth::FixedLag smoother(session, {0}, {nanoseconds(3.0), nanoseconds(1.0)},
                              [&](const smooth::Epoch&) { ++emitted; });
    session.attach({0}, &smoother);
    const auto channel = session.channel("z");
    const double z[] = {0.5};
    int k = 0;
    for (; k < 100; ++k) session.push(channel, no_time, nanoseconds(period * k), z);
    const int before_count = emitted;
    const auto before = conform::allocations();
    for (; k < 200; ++k) session.push(channel, no_time, nanoseconds(period * k), z);
    const auto after = conform::allocations();
    CHECK(emitted >= before_count + 90);
    CHECK(after == before);
  }
}

}  // namespace fixed_lag_test
