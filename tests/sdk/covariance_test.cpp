// SPDX-License-Identifier: Apache-2.0
// binnacle covariance: against closed forms of scalar filters, matched and not, and what it refuses.
#include "catch.hpp"

#include <cmath>

#include <nlohmann/json.hpp>

#include "command.hpp"

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

TEST_CASE("covariance: a reading less all but one block") {
  const Workbench bench;
  const json more = json::parse(R"~({
    "blocks": { "offset": { "type": "vector", "size": 1, "unit": "m", "init": { "x": 0 }, "sigma": 1.5 } },
    "process": { "stays": { "type": "random_constant", "blocks": { "x": "offset" } } },
    "measurements": { "fix": { "blocks": { "bias": "offset" } } } })~");
  const json output{{"outputs", {{"place", {{"measurement", "fix"}, {"block", "place"}}}}}};
  const auto variant = analysed(bench, output, more);
  // At the first sample the offset is not known at all.
  CHECK(agrees(figure(variant, "walk/place/sigma at 0 s"), std::sqrt(1.5 * 1.5 + r * r)));
  CHECK(agrees(figure(variant, "walk/place/sigma"), figure(variant, "walk/place/own sigma")));
}

TEST_CASE("covariance: adaptive noise is refused, and so is what cannot be told") {
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
  refused(R"("covariance": {"outputs": {"x": {"measurement": "fox", "block": "place"}}})", "B015",
          "did you mean 'fix'");
  refused(R"("covariance": {"truth": {"process": {"wander": {"q": -1}}}})", "B009", "truth");
}
