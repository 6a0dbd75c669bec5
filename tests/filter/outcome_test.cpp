// SPDX-License-Identifier: Apache-2.0
// Every offered sample has exactly one outcome, whatever throws, wherever; and who gives what may not be is named at once.
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace outcome_test {

using namespace binnacle;

namespace {

std::shared_ptr<const Composition> composition_of(const std::string& text) {
  return filter_tests::composition_of(text, FICKLE_PLUGIN);
}

struct Faults {
  std::string process, measurement, noise;
};

/// A value that moves by a measured speed and is seen through a derived block; started by a sample where there is a
/// channel for it, else by the input.
std::string config(bool starts_by_sample, const Faults& faults = {}, const std::string& update = "ekf") {
  const std::string init = starts_by_sample ? R"("init": {"channel": "first"})" : R"("init": {"a": 1, "b": 2})";
  return R"({"binnacle": 1,
    "sources": {
      "first": {"type": "pushed", "fields": {"a": {"unit": "m"}, "b": {"unit": "m"}}},
      "v": {"type": "pushed", "fields": {"v": {"unit": "m/s", "kind": "rate"}}},
      "z": {"type": "pushed", "fields": {"z": {"unit": "m"}}},
      "w": {"type": "pushed", "fields": {"z": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "fickle_value", "sigma": [2, 1], )" +
         init + R"(},
                 "held": {"type": "fickle_value", "sigma": 1, "init": {"a": 0, "b": 0}, "estimate": ["a"], "hold": true}},
      "derived": {"sum": {"type": "fickle_sum", "blocks": {"x": "x"}}},
      "process": {"move": {"type": "fickle_move", "input": "v", "blocks": {"x": "x"}, "gives": ")" +
         faults.process + R"("},
                  "decay": {"type": "fickle_decay", "blocks": {"x": "held"}}},
      "measurements": {
        "see": {"type": "fickle_see", "channel": "z", "blocks": {"x": "sum"}, "gate": 0.999, "update": ")" +
         update + R"(",
                "recover": {"after": 2, "inflate": {"x.a": 3}}, "gives": ")" +
         faults.measurement + R"(", "noise": {"type": "fickle_trust", "gives": ")" + faults.noise + R"("}},
        "also": {"type": "fickle_see", "channel": "w", "blocks": {"x": "sum"}, "withhold": {"every": 3}}}},
    "next": {
      "blocks": {"y": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1}},
      "process": {"wander": {"type": "random_walk", "blocks": {"x": "y"}, "q": 1}},
      "measurements": {"cascade": {"type": "linear_measurement", "channel": "f", "blocks": {"x": "y"},
                                   "fields": {"z0": "x.a"}, "sigma": [1]}}}}})";
}

class Outcomes final : public StepObserver {
 public:
  void offered(const UpdateRecord& record) override { seen[record.measurement].push_back(record.t); }
  std::vector<Time> seen[2];
};

constexpr Time ms = 1'000'000;

/// A fuse for the plugin's calls: the `calls`-th one throws.
class Fuse {
 public:
  explicit Fuse(long calls) : fuse_{calls, calls % 2} {
    char address[32];
    std::snprintf(address, sizeof address, "%p", static_cast<void*>(fuse_));
    ::setenv("FICKLE_FUSE", address, 1);
  }
  Fuse(const Fuse&) = delete;
  Fuse& operator=(const Fuse&) = delete;
  ~Fuse() { ::unsetenv("FICKLE_FUSE"); }

 private:
  long fuse_[2];  // until it throws; what: an exception, or an int
};

struct Drive {
  long offered[2] = {};
  std::string diagnosis;
  Outcomes outcomes;
  std::int64_t counted[2] = {};  // Σ outcomes
  std::int64_t counts_offered[2] = {};
  std::int64_t before_start[2] = {};
  std::int64_t recoveries = 0;
};

/// Input with measurements on time, ahead of it, late and beyond the gate. After each push every offered sample has its
/// outcome or waits; a filter that is broken lets none wait.
Drive drive(const std::shared_ptr<const Composition>& composition, long calls) {
  Drive result;
  const Fuse fuse(calls);
  Session session(composition);
  session.attach(FilterId{0}, &result.outcomes);
  const ChannelId v = session.channel("v"), z = session.channel("z"), w = session.channel("w");
  const auto push = [&](ChannelId channel, Time t0, Time t, double value) {
    session.push(channel, t0, t, {&value, 1});
    for (int m = 0; m < 2; ++m) {
      const auto counts = session.counts({{0}, m});
      const auto sum = std::accumulate(std::begin(counts.by_outcome), std::end(counts.by_outcome), std::int64_t{0});
      CHECK(counts.offered + counts.before_start == result.offered[m]);
      CHECK(sum <= counts.offered);
      if (!session.healthy(FilterId{0})) CHECK(sum == counts.offered);
    }
  };
  const auto offer = [&](int m, Time t, double value) {
    ++result.offered[m];
    push(m == 0 ? z : w, no_time, t, value);
  };
  offer(0, 0, 3);
  const double first[] = {1, 2};
  session.push(session.channel("first"), no_time, 0, first);
  for (int i = 0; i < 12; ++i) {
    push(v, i * 10 * ms, (i + 1) * 10 * ms, 1);
    offer(0, (i + 1) * 10 * ms + 4 * ms, i >= 5 && i < 8 ? 1e3 : 3);  // ahead of the input
    offer(1, (i + 1) * 10 * ms, 3);
    if (i % 4 == 1) offer(1, i * 10 * ms - 5 * ms, 3);  // late
  }
  result.diagnosis = session.diagnosis(FilterId{0});
  for (int m = 0; m < 2; ++m) {
    const auto counts = session.counts({{0}, m});
    result.counted[m] = std::accumulate(std::begin(counts.by_outcome), std::end(counts.by_outcome), std::int64_t{0});
    result.counts_offered[m] = counts.offered;
    result.before_start[m] = counts.before_start;
    result.recoveries += counts.recoveries;
  }
  return result;
}

/// "plus" of "plugin 'fickle', component 'fickle_value' (/filters/f/blocks/x): plus at 0.1 s threw: …"
std::string call_of(const std::string& diagnosis) {
  const auto begin = diagnosis.find("): ") + 3;
  return diagnosis.substr(begin, diagnosis.find(' ', begin) - begin);
}

}  // namespace

TEST_CASE("every offered sample has exactly one outcome, whatever throws, wherever") {
  std::set<std::string> calls;
  for (const auto& [starts_by_sample, update] :
       {std::pair(false, "ekf"), std::pair(true, "ekf"), std::pair(false, "iterated"), std::pair(true, "unscented")}) {
    CAPTURE(update);
    const auto composition = composition_of(config(starts_by_sample, {}, update));
    constexpr long never = 1'000'000;
    long used = 0;
    {
      Drive undisturbed = drive(composition, never);
      REQUIRE(undisturbed.diagnosis.empty());
      REQUIRE(undisturbed.recoveries > 0);
      // The last sample on channel z is ahead of the input and still waits.
      REQUIRE(undisturbed.counted[0] == undisturbed.counts_offered[0] - 1);
      REQUIRE(undisturbed.counted[1] == undisturbed.counts_offered[1]);
    }
    for (long call = 1;; ++call) {
      CAPTURE(starts_by_sample, call);
      const Drive result = drive(composition, call);
      if (result.diagnosis.empty()) {
        used = call;  // there are fewer calls than that
        break;
      }
      CHECK(result.diagnosis.find("plugin 'fickle', component 'fickle_") == 0);
      CHECK(result.diagnosis.find(" threw: ") != std::string::npos);
      calls.insert(call_of(result.diagnosis));
      for (int m = 0; m < 2; ++m) {
        CAPTURE(m);
        CHECK(result.counted[m] == result.counts_offered[m]);
        CHECK(static_cast<std::int64_t>(result.outcomes.seen[m].size()) == result.counts_offered[m]);
      }
    }
    CHECK(used > 100);
  }
  CHECK(calls == std::set<std::string>{"after", "estimate", "evaluate", "linearize", "linearized", "minus", "plus",
                                       "propagate", "read", "reset_jacobian", "start", "write"});
}

TEST_CASE("what cannot be noise or is not finite is named at once, with plugin, component, call and sample") {
  const auto diagnosis = [](const Faults& faults) {
    Session session(composition_of(config(false, faults)));
    const ChannelId v = session.channel("v"), z = session.channel("z");
    const double speed = 0, seen = 3;
    for (int i = 0; i < 30; ++i) {
      session.push(v, i * 50 * ms, (i + 1) * 50 * ms, {&speed, 1});
      if (i % 5 == 4) session.push(z, no_time, (i + 1) * 50 * ms, {&seen, 1});
    }
    const auto counts = session.counts({{0}, 0});
    CHECK(std::accumulate(std::begin(counts.by_outcome), std::end(counts.by_outcome), std::int64_t{0}) == 6);
    if (session.healthy(FilterId{0})) return counts.last_reason;
    CHECK(counts.by_outcome[static_cast<int>(Outcome::accepted)] == 4);
    CHECK(counts.by_outcome[static_cast<int>(Outcome::rejected)] == 2);
    return session.diagnosis(FilterId{0});
  };
  const std::string see = "plugin 'fickle', component 'fickle_see' (/filters/f/measurements/see): linearize at 1.25 s";
  CHECK(diagnosis({"", "negative", ""}) == see + " gave R(1, 1) = -1, which is not a variance");
  CHECK(diagnosis({"", "asymmetric", ""}) == see + " gave R(0, 1) = 0.001 but R(1, 0) = 0, which is not symmetric");
  CHECK(diagnosis({"", "no rows", ""}) == "the model reports a negative number of rows");
  CHECK(diagnosis({"", "nan", ""}) == "the noise of the residual is not finite");

  const std::string trust =
      "plugin 'fickle', component 'fickle_trust' (/filters/f/measurements/see): estimate at 1.25 s";
  CHECK(diagnosis({"", "", "negative"}) == trust + " gave R(0, 0) = -4, which is not a variance");
  CHECK(diagnosis({"", "", "nan"}) == trust + " gave R(0, 0) = nan, which is not finite");

  const std::string move = "plugin 'fickle', component 'fickle_move' (/filters/f/process/move): propagate at 1.05 s";
  CHECK(diagnosis({"negative", "", ""}) == move + " gave 'x.a' the process noise -1e-06, which is not a variance");
  CHECK(diagnosis({"nan_phi", "", ""}).find(": " + move + " gave Phi(x, x), which is not finite") != std::string::npos);
  CHECK(diagnosis({"nan_x", "", ""}) ==
        "block 'x' is not finite at 1.05 s: " + move + " gave 'x', which is not finite");
}

}  // namespace outcome_test
