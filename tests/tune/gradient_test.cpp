// SPDX-License-Identifier: Apache-2.0
// The likelihood of a frozen run, and its gradient by the sweep, of random composed linear filters: against the filter's own
// innovations at other noise, central differences, and sensitivities forwards.
#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <nlohmann/json.hpp>

#include "binnacle/eigen.hpp"
#include "line.hpp"
#include "log_recorder.hpp"
#include "tune/linear_log.hpp"

namespace gradient_test {

using namespace binnacle;
using nlohmann::json;

namespace {

struct Push {
  const char* channel;
  double t;
  std::vector<double> fields;
};

/// A chain of blocks of random noise: a position that a velocity moves, a drift, a constant of which a part is frozen.
json chain(std::mt19937& random, bool has_gates, const char* considered = "[]") {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  json config = json::parse(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}},
                "y": {"type": "pushed", "fields": {"z0": {"unit": "m/s"}}}},
    "filters": {"f": {
      "blocks": {
        "x": {"type": "vector", "size": 2, "unit": "m", "init": [1, -1], "sigma": 2},
        "v": {"type": "vector", "size": 2, "unit": "m/s", "init": [0.1, 0]},
        "d": {"type": "vector", "size": 2, "unit": "m"},
        "c": {"type": "vector", "size": 2, "unit": "m", "init": [0.2, 0], "sigma": [0.3, 0.4], "estimate": ["x1"]}},
      "process": {
        "move": {"type": "integrated", "blocks": {"x": "x", "rate": "v"}},
        "wander": {"type": "random_walk", "blocks": {"x": "v"}},
        "drift": {"type": "gauss_markov", "blocks": {"x": "d"}, "tau": "12 s"},
        "stay": {"type": "random_constant", "blocks": {"x": "c"}}},
      "measurements": {
        "both": {"channel": "z", "stack": {
          "p": {"type": "linear_measurement", "blocks": {"x": "x"}},
          "q": {"type": "linear_measurement", "blocks": {"x": "d"}, "sigma": [0.3, 0.6]}}},
        "speed": {"type": "linear_measurement", "channel": "y", "blocks": {"x": "v"}, "H": [[1, 0.5]]}}}}})");
  json& filter = config["filters"]["f"];
  filter["blocks"]["v"]["sigma"] = between(0.1, 1);
  filter["blocks"]["d"]["sigma"] = between(0.5, 2);
  filter["blocks"]["d"]["consider"] = json::parse(considered);
  if (filter["blocks"]["d"]["consider"].empty()) filter["blocks"]["d"].erase("consider");
  filter["process"]["wander"]["q"] = between(0.05, 0.5);
  filter["process"]["drift"]["sigma"] = between(0.3, 1);
  filter["measurements"]["both"]["stack"]["p"]["sigma"] = {between(0.2, 0.8), between(0.2, 0.8)};
  filter["measurements"]["speed"]["sigma"] = {between(0.1, 0.4)};
  // Each form of P in a third of the configs.
  const double q = filter["process"]["wander"]["q"];
  filter["covariance"] = std::vector{"joseph", "ud", "square_root"}[static_cast<std::size_t>(1e6 * q) % 3];
  if (!has_gates) return config;
  filter["measurements"]["both"]["gate"] = {{"probability", 0.99}, {"by", random() % 2 ? "row" : "sample"}};
  filter["measurements"]["both"]["recover"] = {{"after", 3}, {"inflate", {{"x", 0.5}, {"d", 0.2}}}};
  return config;
}

const std::vector<const char*> parameters{"/filters/f/blocks/v/sigma", "/filters/f/process/wander/q",
                                          "/filters/f/process/drift/sigma",
                                          "/filters/f/measurements/both/stack/p/sigma/0",
                                          "/filters/f/measurements/speed/sigma/0"};

/// Uneven times, several samples of an instant; outliers, three in a row now and then.
std::vector<Push> drive(std::mt19937& random, int count, bool has_outliers) {
  std::normal_distribution<double> normal;
  std::vector<Push> pushes;
  double t = 0;
  for (int k = 0; k < count; ++k) {
    t += 0.2 + 0.1 * (k % 3);
    const bool is_outlier = has_outliers && (k % 11 == 5 || (k > 60 && k < 68));
    if (k % 2 == 0) pushes.push_back({"y", t, {0.1 * normal(random)}});
    if (k % 5 != 1) pushes.push_back({"z", t, {1 + normal(random) + (is_outlier ? 30 : 0), -1 + normal(random)}});
  }
  return pushes;
}

std::shared_ptr<const Composition> composed(const json& config) { return filter_tests::composition_of(config.dump()); }

void play(const std::shared_ptr<const Composition>& composition, const std::vector<Push>& pushes,
          StepObserver& observer) {
  Session session(composition);
  session.attach({0}, &observer);
  for (const Push& push : pushes) filter_tests::push(session, push.channel, push.t, push.fields);
}

json changed(json config, const char* parameter, double factor) {
  json& value = config[json::json_pointer(parameter)];
  value = factor * value.get<double>();
  return config;
}

double square(const json& config, const char* parameter) {
  const double value = config.at(json::json_pointer(parameter)).get<double>();
  return value * value;
}

/// The log with a slope by each θ².
struct Case {
  Case(const json& base, const std::vector<Push>& pushes)
      : config(base), composition(composed(base)), run(composition->filters()[0]) {
    tune::LogRecorder recorder(composition->filters()[0], run, tune::Until({}));
    play(composition, pushes, recorder);
    for (const char* parameter : parameters) {
      const json nudged = changed(config, parameter, 1 + 1e-4);
      const double change = square(nudged, parameter) - square(config, parameter);
      tune::SlopeRecorder slopes(run, composition->filters()[0].dof, change, tune::Until({}));
      play(composed(nudged), pushes, slopes);
      missed += slopes.missed() + !slopes.is_alike();
      run.log.begin_parameter();
      for (std::size_t e = 0; e < run.log.events(); ++e) run.log.add_term(e, std::move(slopes.terms()[e]));
    }
  }
  /// By Richardson's extrapolation of central differences, each θ² by parts of itself.
  std::vector<double> differences(const std::vector<double>& c) const {
    std::vector<double> slopes;
    for (std::size_t p = 0; p < c.size(); ++p) {
      const auto slope = [&](double part) {
        const double by = part * square(config, parameters[p]);
        auto above = c, below = c;
        above[p] += by, below[p] -= by;
        return (run.log.likelihood(above) - run.log.likelihood(below)) / (2 * by);
      };
      slopes.push_back((64 * slope(1e-3) - 20 * slope(2e-3) + slope(4e-3)) / 45);
    }
    return slopes;
  }

  json config;
  std::shared_ptr<const Composition> composition;
  tune::RecordedRun run;
  int missed = 0;
};

/// The filter's own.
class Innovations final : public StepObserver {
 public:
  void offered(const UpdateRecord& record) override {
    if (record.outcome != Outcome::accepted) return;
    const Eigen::LLT<Eigen::MatrixXd> S(record.S.as());
    const Eigen::VectorXd r = Eigen::Map<const Eigen::VectorXd>(record.residual, record.rows);
    const double log_det = 2 * Eigen::MatrixXd(S.matrixL()).diagonal().array().log().sum();
    sum -= 0.5 * (r.dot(S.solve(r)) + log_det + record.rows * std::log(2 * M_PI));
  }
  double sum = 0;
};

double worst(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0, largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference = std::max(difference, std::abs(a[i] - b[i]));
    largest = std::max(largest, std::abs(b[i]));
  }
  return difference / largest;
}

}  // namespace

TEST_CASE("the log's likelihood is that of the filter's innovations, at its own noise and at other") {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    const json config = chain(random, false);
    const auto pushes = drive(random, 120, false);
    const Case test(config, pushes);
    std::vector<double> c(parameters.size());
    Innovations own;
    play(composed(config), pushes, own);
    INFO(seed);
    CHECK(std::abs(test.run.log.likelihood(c) - own.sum) < 1e-10 * std::abs(own.sum));
    json other = config;
    for (std::size_t p = 0; p < c.size(); ++p) {
      other = changed(other, parameters[p], p % 2 ? 3.0 : 0.4);
      c[p] = square(other, parameters[p]) - square(config, parameters[p]);
    }
    Innovations at_other;
    play(composed(other), pushes, at_other);
    CHECK(std::abs(own.sum - at_other.sum) > 1);
    CHECK(std::abs(test.run.log.likelihood(c) - at_other.sum) < 1e-9 * std::abs(at_other.sum));
  }
}

TEST_CASE("the sweep's gradient is that of differences in nine digits, and of sensitivities in ten") {
  int left_out = 0, recoveries = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    const json config = chain(random, true);
    const auto pushes = drive(random, 120, true);
    const Case test(config, pushes);
    left_out += static_cast<int>(test.run.refused.size());
    recoveries += test.run.recoveries;
    INFO(seed);
    CHECK(test.missed == 0);
    for (const double part : {0.0, 0.7}) {
      std::vector<double> c, sweep(parameters.size());
      for (const char* parameter : parameters) c.push_back(part * square(config, parameter));
      const double value = test.run.log.likelihood(c, sweep.data());
      CHECK(worst(sweep, test.differences(c)) < 1e-9);
      Eigen::VectorXd forwards;
      Eigen::MatrixXd information;
      CHECK(test.run.log.information(c, forwards, information) == Approx(value).epsilon(1e-13));
      CHECK(worst(sweep, {forwards.data(), forwards.data() + forwards.size()}) < 1e-10);
      CHECK(Eigen::LLT<Eigen::MatrixXd>(information).info() == Eigen::Success);
    }
  }
  CHECK(left_out > 100);
  CHECK(recoveries > 5);
}

TEST_CASE("with considered components the sweep's gradient is not exact, which differences show") {
  std::mt19937 random(3);
  const json config = chain(random, false, R"(["x0"])");
  const Case test(config, drive(random, 120, false));
  REQUIRE(test.run.log.has_considered());
  std::vector<double> c(parameters.size()), sweep(parameters.size());
  test.run.log.likelihood(c, sweep.data());
  CHECK(worst(sweep, test.differences(c)) > 1e-4);
}

TEST_CASE("Fisher's information is the covariance of the gradient where the noise is true") {
  // Of a place that wanders, by many draws.
  const json config = json::parse(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"v": {"type": "vector", "size": 1, "unit": "m", "sigma": 1}},
      "process": {"wander": {"type": "random_walk", "blocks": {"x": "v"}, "q": 0.4}},
      "measurements": {"seen": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "v"}, "sigma": [0.5]}}}}})");
  const char* const both[] = {"/filters/f/process/wander/q", "/filters/f/measurements/seen/sigma/0"};
  const auto composition = composed(config);
  std::vector<std::shared_ptr<const Composition>> nudged;
  std::vector<double> changes;
  for (const char* parameter : both) {
    const json other = changed(config, parameter, 1 + 1e-4);
    nudged.push_back(composed(other));
    changes.push_back(square(other, parameter) - square(config, parameter));
  }
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(2, 2), information;
  constexpr int draws = 400;
  for (int k = 0; k < draws; ++k) {
    std::vector<Push> pushes;
    double place = normal(random);
    for (int i = 0; i < 60; ++i) {
      if (i > 0) place += 0.4 * normal(random);
      pushes.push_back({"z", static_cast<double>(i), {place + 0.5 * normal(random)}});
    }
    tune::RecordedRun run(composition->filters()[0]);
    tune::LogRecorder recorder(composition->filters()[0], run, tune::Until({}));
    play(composition, pushes, recorder);
    for (std::size_t p = 0; p < 2; ++p) {
      tune::SlopeRecorder slopes(run, 1, changes[p], tune::Until({}));
      play(nudged[p], pushes, slopes);
      run.log.begin_parameter();
      for (std::size_t e = 0; e < run.log.events(); ++e) run.log.add_term(e, std::move(slopes.terms()[e]));
    }
    Eigen::VectorXd gradient;
    run.log.information(std::vector<double>(2), gradient, information, k + 1 < draws ? 1 : 4000);
    scatter += gradient * gradient.transpose() / draws;
  }
  // Of 400 draws an entry is known to about 1/√200.
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      CHECK(std::abs(scatter(i, j) - information(i, j)) < 4 * 0.071 * std::sqrt(information(i, i) * information(j, j)));
}

}  // namespace gradient_test
