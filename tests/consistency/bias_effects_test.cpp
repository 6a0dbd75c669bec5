// SPDX-License-Identifier: Apache-2.0
// The effect of a bias of a row on the estimates, against a filter that has this bias and nothing else.
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "bias_effects.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"

namespace bias_effects_test {

using namespace binnacle;
using score::BiasEffects;

namespace {

/// Nearly constant velocity north and east, by plots of the position and a log of the velocity; a Gauss-Markov current.
constexpr const char* config = R"({"binnacle": 1,
  "sources": {
    "plots": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}},
    "log": {"type": "pushed", "fields": {"z0": {"unit": "m/s"}}}},
  "filters": {"f": {
    "blocks": {
      "position": {"type": "vector", "size": 2, "unit": "m", "init": [0, 0], "sigma": 5},
      "velocity": {"type": "vector", "size": 2, "unit": "m/s", "init": [0, 0], "sigma": 1},
      "current": {"type": "vector", "size": 1, "unit": "m/s", "init": [0], "sigma": 0.5}},
    "process": {
      "move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
      "turns": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": 0.01},
      "drift": {"type": "gauss_markov", "blocks": {"x": "current"}, "tau": "20 s", "sigma": 0.5}},
    "measurements": {
      "plot": {"type": "linear_measurement", "channel": "plots", "blocks": {"x": "position"}, "sigma": [3, 4]},
      "log": {"type": "linear_measurement", "channel": "log", "blocks": {"x": "current"}, "sigma": [0.2]}}}}})";

class Follower final : public StepObserver {
 public:
  explicit Follower(const FilterInfo& filter) : effects(filter) {}
  Wants wants() const override { return effects.wants(); }
  void started(Time t, const double*, ConstMatrixView) override { effects.started(t); }
  void stepped(const StepRecord& record) override { effects.stepped(record); }
  void offered(const UpdateRecord& record) override { effects.offered(record); }
  BiasEffects effects;
};

/// Plots every `dt`; all of them are zero but for a bias of row 1. Ends with the first window.
struct Run {
  Run(double bias, double dt) {
    ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
    Session session(Composition::parse(config, "test.json"));
    Follower follower(session.composition().filters().front());
    session.attach({0}, &follower);
    for (double t = 0; t <= 30 + dt / 2; t += dt) {
      const double plot[] = {0, bias}, current[] = {0};
      session.push(session.channel("plots"), no_time, nanoseconds(t), plot);
      session.push(session.channel("log"), no_time, nanoseconds(t), current);
    }
    const auto x = session.state({0});
    state.assign(x.begin(), x.end());
    const auto* const row = follower.effects.find(0, 0, 1);
    REQUIRE(row);
    unseen = row->unseen;
    for (int i = 0; i < static_cast<int>(state.size()); ++i)
      largest.push_back(follower.effects.effect(*row, i).largest);
  }
  std::vector<double> state, largest;
  double unseen = 0;
};

constexpr double upper_95 = 1.645, found_by = 4.5 + 1.2816;  // as bias_effects.cpp has them

}  // namespace

TEST_CASE("what a bias did to the estimates is what it did") {
  constexpr double bias = 100;
  const Run run(bias, 1);
  REQUIRE(run.unseen > 0);
  for (std::size_t i = 0; i < run.state.size(); ++i) {
    INFO(i);
    const double s = std::abs(run.state[i]) / bias;
    CHECK(run.largest[i] == Approx(s * (bias + upper_95 * run.unseen / found_by)).epsilon(1e-9).margin(1e-12));
  }
  CHECK(run.largest[1] > 50);
  CHECK(run.largest[0] == 0);
  CHECK(run.largest[4] == 0);
}

TEST_CASE("steps much shorter than 0.1 s are taken together, to 2 %") {
  constexpr double bias = 100;
  const Run run(bias, 0.02);
  for (const std::size_t i : {1, 3}) {
    INFO(i);
    const double s = std::abs(run.state[i]) / bias;
    CHECK(run.largest[i] == Approx(s * (bias + upper_95 * run.unseen / found_by)).epsilon(0.02));
  }
}

TEST_CASE("rows of a measurement that is not watched are not followed") {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = {R"(/filters/f/trust={"except": ["plot"]})"};
  Session session(Composition::parse(config, "test.json", options));
  Follower follower(session.composition().filters().front());
  session.attach({0}, &follower);
  for (int t = 0; t < 40; ++t) {
    const double plot[] = {0, 0}, current[] = {0};
    session.push(session.channel("plots"), no_time, nanoseconds(t), plot);
    session.push(session.channel("log"), no_time, nanoseconds(t), current);
  }
  CHECK_FALSE(follower.effects.find(0, 0, 0));
  CHECK(follower.effects.find(1, 0, 0));
}

}  // namespace bias_effects_test
