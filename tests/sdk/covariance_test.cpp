// SPDX-License-Identifier: Apache-2.0
// binnacle covariance: against closed forms of scalar filters, matched and not, and what it refuses.
#include "catch.hpp"

#include <cmath>

#include <nlohmann/json.hpp>

#include "command.hpp"

namespace covariance_test {

using namespace binnacle::test;
using nlohmann::json;

namespace {

constexpr double q = 0.3;  // of the random walk, per step of 1 s [m]
constexpr double r = 2.0;  // of the measurement [m]

/// A place that wanders, seen once a second; `covariance` is added to the section, `more` to the filter.
json analysed(const Workbench& bench, const json& covariance = json::object(), const json& more = json::object()) {
  json config = json::parse(R"~({
    "binnacle": 1, "title": "a place",
    "sources": { "seen": { "type": "pushed", "fields": { "z": { "unit": "m" } } } },
    "filters": { "walk": {
      "blocks": { "place": { "type": "vector", "size": 1, "unit": "m", "init": { "x": 0 }, "sigma": 5 } },
      "process": { "wander": { "type": "random_walk", "blocks": { "x": "place" }, "q": 0.3 } },
      "measurements": { "fix": { "type": "linear_measurement", "channel": "seen", "fields": { "z0": "z" },
                                 "blocks": { "x": "place" }, "H": [[1]], "sigma": [2] } } } },
    "covariance": { "duration": "500 s", "channels": { "seen": { "interval": "1 s" } },
                    "metrics": ["walk/place/sigma", "walk/place/own sigma", "walk/place/sigma at 0 s", "walk/place/settled"] }
  })~");
  config["covariance"].merge_patch(covariance);
  config["filters"]["walk"].merge_patch(more);
  bench.write("c.json", config.dump());
  const auto outcome = binnacle::test::binnacle(bench, {"covariance", "c.json", "--json"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(outcome.out).at("variants").at("base");
}

double figure(const json& variant, const std::string& metric) {
  return variant.at("metrics").at(metric).at("mean").get<double>();
}

/// Of the scalar filter in the steady state with this r.
double steady_gain(double own_r) {
  const double before = 0.5 * (q * q + std::sqrt(q * q * q * q + 4 * q * q * own_r * own_r));
  return before / (before + own_r * own_r);
}

/// True variance after an update by a constant gain.
double true_variance(double k) { return ((1 - k) * (1 - k) * q * q + k * k * r * r) / (1 - (1 - k) * (1 - k)); }

bool agrees(double a, double b) { return std::abs(a - b) < 1e-9 * std::abs(b); }

}  // namespace

TEST_CASE("covariance: the steady state of a scalar filter") {
  const Workbench bench;
  const auto variant = analysed(bench);
  CHECK(agrees(figure(variant, "walk/place/sigma"), std::sqrt(steady_gain(r)) * r));
  CHECK(agrees(figure(variant, "walk/place/own sigma"), std::sqrt(steady_gain(r)) * r));
  CHECK(agrees(figure(variant, "walk/place/sigma at 0 s"), std::sqrt(25 * 4 / 29.0)));
  const double settled = figure(variant, "walk/place/settled");
  CHECK(settled > 1);
  CHECK(settled < 30);
  double shares = 0;
  for (const auto& [source, share] : variant.at("budget").at("walk/place").items()) shares += share.get<double>();
  CHECK(std::abs(shares - 1) < 1e-12);
  const double k = steady_gain(r);
  CHECK(agrees(variant.at("budget").at("walk/place").at("noise of fix").get<double>() * k * r * r,
               k * k * r * r / (1 - (1 - k) * (1 - k))));
}

TEST_CASE("covariance: a truth with other noise than the filter believes") {
  const Workbench bench;
  const json wrong{{"measurements", {{"fix", {{"sigma", {6}}}}}}}, right{{"measurements", {{"fix", {{"sigma", {2}}}}}}};
  const auto variant = analysed(bench, {{"truth", right}}, wrong);
  CHECK(agrees(figure(variant, "walk/place/sigma"), std::sqrt(true_variance(steady_gain(6)))));
  CHECK(agrees(figure(variant, "walk/place/own sigma"), std::sqrt(steady_gain(6)) * 6));
  CHECK(figure(variant, "walk/place/sigma") > std::sqrt(steady_gain(r)) * r);
}

TEST_CASE("covariance: a truth with a block that the filter lacks") {
  const Workbench bench;
  const json truth = json::parse(R"~({
    "blocks": { "offset": { "type": "vector", "size": 1, "unit": "m", "init": { "x": 0 }, "sigma": 1.5 } },
    "process": { "stays": { "type": "random_constant", "blocks": { "x": "offset" } } },
    "measurements": { "fix": { "blocks": { "bias": "offset" } } } })~");
  const auto variant = analysed(bench, {{"truth", truth}});
  // In the steady state the offset is in the estimate whole, with the other sign in the error.
  const double k = steady_gain(r);
  CHECK(agrees(figure(variant, "walk/place/sigma"), std::sqrt(k * r * r + 1.5 * 1.5)));
  CHECK(agrees(figure(variant, "walk/place/own sigma"), std::sqrt(k) * r));
}

TEST_CASE("covariance: what is considered has no gain") {
  const Workbench bench;
  const json more = json::parse(R"~({
    "blocks": { "offset": { "type": "vector", "size": 1, "unit": "m", "init": { "x": 0 }, "sigma": 1.5, "estimate": [],
                            "consider": ["x"] } },
    "process": { "stays": { "type": "random_constant", "blocks": { "x": "offset" } } },
    "measurements": { "fix": { "blocks": { "bias": "offset" } } } })~");
  const auto variant = analysed(bench, json::object(), more);
  CHECK(agrees(figure(variant, "walk/place/sigma"), figure(variant, "walk/place/own sigma")));
  CHECK(figure(variant, "walk/place/sigma") > 1.5);
}

TEST_CASE("covariance: an implied state less all but one block") {
  const Workbench bench;
  const json more = json::parse(R"~({
    "blocks": { "offset": { "type": "vector", "size": 1, "unit": "m", "init": { "x": 0 }, "sigma": 1.5 } },
    "process": { "stays": { "type": "random_constant", "blocks": { "x": "offset" } } },
    "measurements": { "fix": { "blocks": { "bias": "offset" } } } })~");
  json implied_state = more;
  implied_state["implied_states"] = {{"direct", {{"measurement", "fix"}, {"block", "place"}}}};
  const auto variant = analysed(bench, {{"outputs", {{"place", "direct"}}}}, implied_state);
  // At the first sample the offset is not known at all.
  CHECK(agrees(figure(variant, "walk/place/sigma at 0 s"), std::sqrt(1.5 * 1.5 + r * r)));
  CHECK(agrees(figure(variant, "walk/place/sigma"), figure(variant, "walk/place/own sigma")));
  // Under its own name, beside the block.
  const auto both = analysed(bench, {{"metrics", {"walk/place/sigma", "walk/direct/sigma", "walk/direct.x/own sigma"}}},
                             implied_state);
  CHECK(agrees(figure(both, "walk/direct/sigma"), figure(variant, "walk/place/sigma")));
  CHECK(agrees(figure(both, "walk/direct.x/own sigma"), figure(variant, "walk/place/sigma")));
  CHECK(figure(both, "walk/place/sigma") < figure(both, "walk/direct/sigma"));
}

namespace {

/// The ship of paper 004 by its simulator, once a second; `covariance` is merged over the section, `more` over the config.
json simulated(const Workbench& bench, const json& covariance, const json& more = json::object()) {
  json config = json::parse(R"~({
    "binnacle": 1,
    "sources": { "sea": { "type": "simulator", "omega": [1.98], "zeta": [0.2235], "sigma": "0.825 deg", "noise": "0.5 deg",
                          "drift": "60 deg/h", "interval": "1 s", "duration": "60 s" } },
    "filters": { "ship": {
      "blocks": {
        "pitch": { "type": "vector", "size": 1, "unit": "rad", "init": { "x": 0 }, "sigma": "0.825 deg" },
        "pitch_rate": { "type": "vector", "size": 1, "unit": "rad/s", "init": { "x": 0 }, "sigma": "1.6335 deg/s" },
        "error": { "type": "vector", "size": 1, "unit": "rad", "init": { "x": 0 }, "sigma": 0 },
        "drift": { "type": "vector", "size": 1, "unit": "rad/s", "init": { "x": 0 }, "sigma": "60 deg/h" } },
      "process": {
        "motion": { "type": "motion", "blocks": { "angle": "pitch", "rate": "pitch_rate" }, "omega": [1.98], "zeta": [0.2235],
                    "sigma": "0.825 deg" },
        "accumulation": { "type": "integrated", "blocks": { "x": "error", "rate": "drift" } },
        "drifting": { "type": "gauss_markov", "blocks": { "x": "drift" }, "tau": "3600 s", "sigma": "60 deg/h" } },
      "measurements": { "vertical": { "type": "vertical_gyro", "channel": "sea.gyro", "fields": { "pitch": "angle" }, "sigma": "1 deg",
                                      "blocks": { "pitch": "pitch", "pitch_error": "error" } } } } },
    "reference": [ { "channel": "sea.truth", "blocks": { "ship/pitch": ["angle"] } } ],
    "covariance": { "truth": { "measurements": { "vertical": { "sigma": "0.5 deg" } } },
                    "metrics": ["ship/pitch/sigma", "ship/pitch/own sigma", "ship/pitch/sigma at 30 s", "ship/drift/sigma"] }
  })~");
  config["covariance"].merge_patch(covariance);
  config.merge_patch(more);
  bench.write("s.json", config.dump());
  const auto outcome = binnacle::test::binnacle(bench, {"covariance", "s.json", "--json"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  return json::parse(outcome.out).at("variants").at("base");
}

const json error_free{{"error_free", {{"sea", {{"sigma", 0}, {"noise", 0}, {"drift", 0}}}}}};

}  // namespace

TEST_CASE("covariance: along a run of the config's own sources it gives the same as of channels that are fed") {
  const Workbench bench;
  const auto fed = simulated(bench, {{"duration", "60 s"}, {"channels", {{"sea.gyro", {{"interval", "1 s"}}}}}});
  const auto ran = simulated(bench, error_free);
  for (const auto& [metric, entry] : fed.at("metrics").items()) {
    INFO(metric);
    CHECK(agrees(figure(ran, metric), entry.at("mean").get<double>()));
  }
  CHECK(figure(fed, "ship/pitch/sigma") < figure(fed, "ship/pitch/own sigma"));
  for (const auto& [source, share] : fed.at("budget").at("ship/pitch").items())
    CHECK(agrees(ran.at("budget").at("ship/pitch").at(source).get<double>(), share.get<double>()));
}

TEST_CASE(
    "covariance: a duration ends a run of sources, a linear filter has the same figures along any run, or several") {
  const Workbench bench;
  const auto whole = simulated(bench, error_free);
  json shorter = error_free;
  shorter["duration"] = "30 s";
  CHECK(agrees(figure(simulated(bench, shorter), "ship/pitch/sigma"), figure(whole, "ship/pitch/sigma at 30 s")));
  const auto several = simulated(bench, {{"runs", 3}});
  CHECK(several.at("runs") == 3);
  CHECK(
      agrees(several.at("metrics").at("ship/pitch/sigma").at("rms").get<double>(), figure(whole, "ship/pitch/sigma")));
}

TEST_CASE("covariance: what is given between measurements and where there are none") {
  const Workbench bench;
  // Drift alone: an error that the drift integrates, q left out by an endless correlation time.
  json covariance = error_free;
  covariance["metrics"] = {"ship/error/sigma", "ship/error/sigma at 0 s"};
  covariance["truth"] = nullptr;
  covariance["duration"] = "10 s";
  const json more = json::parse(R"~({ "filters": { "ship": {
    "process": { "drifting": { "type": "random_constant", "tau": null, "sigma": null } },
    "measurements": { "vertical": { "withhold": { "every": 1 } } } } } })~");
  const auto variant = simulated(bench, covariance, more);
  CHECK(agrees(figure(variant, "ship/error/sigma"), 10 * 60 * std::acos(-1) / 180 / 3600));
  CHECK(figure(variant, "ship/error/sigma at 0 s") == 0);
}

TEST_CASE("covariance: errors at the start that are those of another block") {
  const Workbench bench;
  const json more = json::parse(R"~({
    "blocks": { "offset": { "type": "vector", "size": 1, "unit": "m", "init": { "x": 0 }, "sigma": 1.5 } },
    "process": { "stays": { "type": "random_constant", "blocks": { "x": "offset" } } },
    "measurements": { "fix": { "blocks": { "bias": "offset" } } } })~");
  const json covariance = json::parse(R"~({ "initial": { "place": { "of": "offset", "by": [[-1]] } }, "truth": {},
    "metrics": ["walk/place/sigma at 0 s", "walk/place/own sigma at 0 s"] })~");
  const auto variant = analysed(bench, covariance, more);
  // place = p − o, so the first fix is p + v; the filter believes p + o + v, both independent.
  const double s = 25 + 1.5 * 1.5 + 4, k = 25 / s;
  CHECK(agrees(figure(variant, "walk/place/own sigma at 0 s"), std::sqrt(25 - k * 25)));
  CHECK(agrees(figure(variant, "walk/place/sigma at 0 s"), std::sqrt((1 - k) * (1 - k) * 25 + 1.5 * 1.5 + k * k * 4)));
}

TEST_CASE("covariance: readable outputs and norms of a block") {
  const Workbench bench;
  bench.write("a.json", R"~({
    "binnacle": 1,
    "sources": { "seen": { "type": "pushed", "fields": { "z": { "unit": "m" } } } },
    "filters": { "f": {
      "blocks": { "attitude": { "type": "navigation/attitude", "init": { "roll": 0.3, "pitch": 0.2, "yaw": 1.1 },
                                "sigma": [0.01, 0.02, 0.03] },
                  "place": { "type": "vector", "size": 1, "unit": "m", "init": { "x": 0 }, "sigma": 1 } },
      "process": { "turns_not": { "type": "random_constant", "blocks": { "x": "attitude" } },
                   "stays": { "type": "random_constant", "blocks": { "x": "place" } } },
      "measurements": { "fix": { "type": "linear_measurement", "channel": "seen", "fields": { "z0": "z" },
                                 "blocks": { "x": "place" }, "sigma": [1] } } } },
    "covariance": { "duration": "1 s", "channels": { "seen": { "interval": "1 s" } },
                    "metrics": [{ "metric": "f/attitude.yaw/sigma", "unit": "rad" }, { "metric": "f/attitude.east/sigma", "unit": "rad" },
                                { "metric": "f/attitude.tilt/own sigma", "unit": "rad" }] }
  })~");
  const auto outcome = binnacle::test::binnacle(bench, {"covariance", "a.json", "--json"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const auto variant = json::parse(outcome.out).at("variants").at("base");
  // dyaw = tan(pitch) (cos(yaw) north + sin(yaw) east) + down
  const double t = std::tan(0.2);
  const double yaw = std::hypot(t * std::cos(1.1) * 0.01, t * std::sin(1.1) * 0.02, 0.03);
  CHECK(std::abs(figure(variant, "f/attitude.yaw/sigma") - yaw) < 1e-8);
  CHECK(agrees(figure(variant, "f/attitude.east/sigma"), 0.02));
  CHECK(agrees(figure(variant, "f/attitude.tilt/own sigma"), std::hypot(0.01, 0.02)));
}

TEST_CASE("covariance: adaptive noise is refused, and so is what cannot be computed") {
  const Workbench bench;
  const auto refused = [&](const std::string& patched, const std::string& code, const std::string& words) {
    bench.write("wrong.json", "{ \"extends\": \"c.json\", " + patched + " }");
    const auto outcome = binnacle::test::binnacle(bench, {"covariance", "wrong.json"});
    INFO(patched << "\n" << outcome.err);
    CHECK(outcome.status == 3);
    CHECK(outcome.err.find("[" + code + "]") != std::string::npos);
    CHECK(outcome.err.find(words) != std::string::npos);
  };
  analysed(bench);
  refused(R"("filters": {"walk": {"measurements": {"fix": {"noise": {"type": "beta_adapter"}}}}})", "B094",
          "adaptive noise");
  refused(R"("covariance": {"truth": {"measurements": {"fix": {"noise": {"type": "beta_adapter"}}}}})", "B094",
          "adaptive noise");
  refused(R"("covariance": {"metrics": ["walk/place/rms"]})", "B027", "settled");
  refused(R"("covariance": {"metrics": ["walk/plaice/sigma"]})", "B027", "did you mean 'place'");
  refused(R"("covariance": {"channels": {"sean": {"interval": "1 s"}}})", "B020", "did you mean 'seen'");
  refused(R"("covariance": {"channels": {"seen": {"interval": "0 s"}}})", "B009", "above zero");
  refused(R"("covariance": {"durations": "1 s"})", "B012", "did you mean 'duration'");
  refused(R"("covariance": {"outputs": {"x": "direct"}})", "B015", "no implied state 'direct'");
  refused(R"("covariance": {"runs": 3})", "B012", "remove one of the two");
  refused(R"("covariance": {"channels": {"seen": null}})", "B010", "no channel emits");
  refused(R"("covariance": {"initial": {"place": {"of": "plaice", "by": [[1]]}}})", "B015",
          "there is no block 'plaice'");
  refused(R"("covariance": {"initial": {"place": {"of": "place", "by": [1]}}})", "B013", "1 rows of 1");
  refused(R"("covariance": {"truth": {"process": {"wander": {"q": -1}}}})", "B009", "truth");
}

}  // namespace covariance_test
