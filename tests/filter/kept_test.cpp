// SPDX-License-Identifier: Apache-2.0
// What the kernel keeps of time-invariant models while steps are equally long: the same bits as made anew, from fewer calls.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/catalog.hpp"
#include "binnacle/plugin.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace kept_test {

using namespace binnacle;
using filter_tests::push;

namespace {

/// Every kind of what is kept: a group that is discretized together, one with a component that is frozen, a scaled vector, one
/// that stands still, and an attitude, which is no vector.
const char* const kept_config = R"({"binnacle": 1,
  "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
  "filters": {"f": {
    "blocks": {
      "position": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2},
      "velocity": {"type": "vector", "size": 1, "unit": "m/s", "init": 0.5, "sigma": 0.3},
      "pair": {"type": "vector", "size": 2, "unit": "m", "init": [3, -1], "sigma": [1, 0.5], "estimate": ["x0"]},
      "pair_rate": {"type": "vector", "size": 2, "unit": "m/s", "init": [0.1, 0.2], "sigma": 0.1},
      "error": {"type": "vector", "size": 3, "unit": "m", "init": [0.1, -0.2, 0.3], "sigma": 1},
      "wander": {"type": "vector", "size": 1, "unit": "m", "init": 0.2, "sigma": 1},
      "constant": {"type": "vector", "size": 1, "unit": "m", "init": 0.7, "sigma": 1},
      "attitude": {"type": "attitude", "init": {"roll": 0.1, "pitch": 0.2, "yaw": 0.3}, "sigma": 0.1}},
    "process": {
      "move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
      "speed": {"type": "gauss_markov", "blocks": {"x": "velocity"}, "tau": "20 s", "sigma": 0.5},
      "pair_moves": {"type": "integrated", "blocks": {"x": "pair", "rate": "pair_rate"}},
      "pair_speed": {"type": "random_walk", "blocks": {"x": "pair_rate"}, "q": 0.1},
      "error_fades": {"type": "gauss_markov", "blocks": {"x": "error"}, "tau": [5, 7, 9], "sigma": [1, 2, 3]},
      "wanders": {"type": "random_walk", "blocks": {"x": "wander"}, "q": 0.3},
      "stands": {"type": "random_constant", "blocks": {"x": "constant"}},
      "points": {"type": "random_constant", "blocks": {"x": "attitude"}}},
    "measurements": {"fix": {"type": "linear_measurement", "channel": "z",
      "blocks": {"x": "position"}, "sigma": [0.7]}}}}})";

std::vector<std::byte> snapshot_of(const Session& session) {
  std::vector<std::byte> bytes(session.snapshot_size());
  session.snapshot(bytes);
  return bytes;
}

/// Times of samples with runs of equally long steps, others between them, and one of no length.
std::vector<double> times() {
  std::vector<double> all = {0.0};
  for (const double dt : {0.25, 0.25, 0.25, 0.5, 0.25, 0.25, 0.0, 0.25, 1.5, 1.5, 0.125, 1.5, 1.5})
    all.push_back(all.back() + dt);
  return all;
}

int linearizations = 0, propagations = 0, without_blocks = 0;

/// Decays; counts its calls.
template <bool is_time_invariant>
class Counted final : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = is_time_invariant ? "kept_decay" : "asked_decay";
    spec.summary = "A decay that counts its calls.";
    spec.parameters = {parameter::boolean("is_closed").defaults("false").about("by its closed form")};
    spec.ports = {advances("x", "vector:1:m", "what decays")};
    spec.example = R"({"blocks": {"x": "x"}})";
    return spec;
  }
  explicit Counted(const Binding& binding) : x_(binding.port("x")) {
    phi_ = declaration_.couples(x_, x_);
    q_ = declaration_.adds_noise(x_, x_);
    if (!binding.parameters().boolean("is_closed")) declaration_.only_continuous();
    if (is_time_invariant) declaration_.time_invariant();
  }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    ++propagations;
    without_blocks += !out.phi && !out.Qd;
    const double factor = 1 / (1 + 0.5 * in.step.dt);
    out.x[x_][0] = in.x[x_][0] * factor;
    if (const auto phi = out.phi[phi_]) phi.as()(0, 0) = factor;
    if (const auto Q = out.Qd[q_]) Q.as()(0, 0) = in.step.dt;
    return Result::ok();
  }
  void linearized(const ContinuousInput&, ContinuousOutput& out) const override {
    ++linearizations;
    out.F[phi_].as()(0, 0) = -0.5;
    out.GQGt[q_].as()(0, 0) = 1;
  }

 private:
  Port x_;
  PhiBlock phi_;
  QBlock q_;
};

Session counted(const std::string& type, bool is_closed) {
  linearizations = propagations = without_blocks = 0;
  LoadOptions options;
  options.linked_plugins.push_back(
      std::make_shared<LinkedPlugin>(LinkedPlugin{"counted", "1.0.0", [](Registry& registry) {
                                                    registry.add<Counted<true>>();
                                                    registry.add<Counted<false>>();
                                                  }}));
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  return Session(Composition::parse(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2}},
      "process": {"decays": {"type": ")" +
                                        type + R"(", "blocks": {"x": "x"}, "is_closed": )" +
                                        (is_closed ? "true" : "false") + R"(}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"},
                               "sigma": [0.7]}}}}})",
                                    "test.json", options));
}

std::vector<double> run(Session& session) {
  for (const double t : times()) push(session, "z", t, {1.1 + t});
  const auto x = session.state(FilterId{0});
  std::vector<double> all(x.begin(), x.end());
  all.push_back(session.covariance(FilterId{0})(0, 0));
  return all;
}

}  // namespace

TEST_CASE("what is kept of time-invariant models has the bits of what is made anew") {
  const auto composition = filter_tests::composition_of(kept_config);
  Session keeping(composition);
  for (const double t : times()) {
    // A session that has taken no step has nothing to keep.
    Session anew(composition);
    anew.restore(snapshot_of(keeping));
    push(anew, "z", t, {1.1 + t});
    push(keeping, "z", t, {1.1 + t});
    REQUIRE(keeping.healthy(FilterId{0}));
    REQUIRE(snapshot_of(anew) == snapshot_of(keeping));
  }
  REQUIRE(keeping.counts(FilterId{0}).steps == static_cast<std::int64_t>(times().size()) - 2);
}

TEST_CASE("a time-invariant model is asked again only when the length of the step changes") {
  constexpr int lengths = 6, steps = 12;  // of times(): runs of equally long steps, and steps
  Session kept = counted("counted/kept_decay", false);
  const auto by_kept = run(kept);
  REQUIRE(linearizations == lengths);
  Session asked = counted("counted/asked_decay", false);
  REQUIRE(run(asked) == by_kept);
  REQUIRE(linearizations == steps);
}

TEST_CASE("the closed form of a time-invariant model is asked for x+ alone while steps are equally long") {
  Session kept = counted("counted/kept_decay", true);
  const auto by_kept = run(kept);
  REQUIRE(propagations == 12);
  REQUIRE(without_blocks == 12 - 6);
  Session asked = counted("counted/asked_decay", true);
  REQUIRE(run(asked) == by_kept);
  REQUIRE(without_blocks == 0);
}

}  // namespace kept_test
