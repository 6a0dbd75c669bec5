// SPDX-License-Identifier: Apache-2.0
// A filter that is propagated by sigma points, smoothed: exact where it is linear, less overconfident than by Jacobians where it is not.
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <boost/math/distributions/chi_squared.hpp>

#include "binnacle/eigen.hpp"
#include "catch.hpp"
#include "line.hpp"
#include "smooth/interval_smoother.hpp"

namespace unscented_propagation_test {

using namespace binnacle;
using filter_tests::composition_of;
using filter_tests::line;
using filter_tests::push;

namespace {

struct Estimate {
  Eigen::VectorXd x;
  Eigen::MatrixXd P;
};

/// Smoothed estimates at the samples, in order of time.
std::vector<Estimate> smoothed(const std::shared_ptr<const Composition>& composition,
                               const std::vector<std::vector<double>>& samples) {
  Session session(composition);
  smooth::SmoothedFilter filter(session, 0);
  session.attach({0}, &filter.stretch());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    push(session, "z", static_cast<double>(k), samples[k]);
    filter.mark();
  }
  const int stored = session.composition().filters()[0].stored_size;
  std::vector<Estimate> all;
  filter.sweep(
      [&](const smooth::Epoch& epoch) {
        all.insert(all.begin(), {Eigen::Map<const Eigen::VectorXd>(epoch.x, stored), epoch.P.as()});
      },
      [](smooth::WithheldSample) {});
  return all;
}

/// The filter of a config with "propagation": "unscented".
std::string unscented(std::string text) {
  const std::string before = "\"measurements\"";
  return text.replace(text.find(before), before.size(), "\"propagation\": \"unscented\", " + before);
}

const std::string driving = R"({"binnacle": 1,
  "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}}},
  "filters": {"f": {
    "blocks": {"position": {"type": "vector", "size": 2, "unit": "m", "sigma": 1},
               "heading": {"type": "vector", "size": 1, "unit": "rad", "sigma": "40 deg"}},
    "process": {"drive": {"type": "drive", "blocks": {"position": "position", "heading": "heading"}, "speed": 2,
                          "noise": 0.3, "turn_noise": 0.3}},
    "measurements": {"z": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "position"}, "sigma": [4]}}}}})";

}  // namespace

TEST_CASE("smoothing: what is linear is the same whether it was propagated by Jacobians or by sigma points") {
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  std::vector<std::vector<double>> samples;
  for (int k = 0; k < 50; ++k) samples.push_back({1 + 0.5 * k + 0.7 * normal(engine)});
  const auto ekf = smoothed(composition_of(line("")), samples),
             points = smoothed(composition_of(unscented(line(""))), samples);
  REQUIRE(ekf.size() == points.size());
  REQUIRE(ekf.size() == 50);
  for (std::size_t k = 0; k < ekf.size(); ++k) {
    CHECK((ekf[k].x - points[k].x).norm() < 1e-9 * (1 + ekf[k].x.norm()));
    CHECK((ekf[k].P - points[k].P).norm() < 1e-9 * ekf[k].P.norm());
  }
}

TEST_CASE("smoothing a heading that is hardly known: overconfident by Jacobians, by sigma points far less") {
  constexpr int runs = 200, steps = 12;
  const auto by_points = composition_of(unscented(driving), SPIN_PLUGIN),
             by_jacobians = composition_of(driving, SPIN_PLUGIN);
  std::vector<double> points(steps, 0.0), jacobians(steps, 0.0);
  std::mt19937 engine(7);
  std::normal_distribution<double> normal;
  for (int run = 0; run < runs; ++run) {
    std::vector<Eigen::Vector3d> truth = {{normal(engine), normal(engine), 40 * M_PI / 180 * normal(engine)}};
    std::vector<std::vector<double>> samples;
    for (int k = 0; k < steps; ++k) {
      Eigen::Vector3d next = truth.back();
      samples.push_back({next[0] + 4 * normal(engine), next[1] + 4 * normal(engine)});
      next[0] += 2 * std::cos(next[2]) + 0.3 * normal(engine);
      next[1] += 2 * std::sin(next[2]) + 0.3 * normal(engine);
      next[2] += 0.3 * normal(engine);
      truth.push_back(next);
    }
    const auto add = [&](const std::vector<Estimate>& estimates, std::vector<double>& sums) {
      for (std::size_t k = 0; k < estimates.size(); ++k) {
        const Eigen::VectorXd error = truth[k] - estimates[k].x;
        sums[k] += error.dot(estimates[k].P.ldlt().solve(error)) / runs;
      }
    };
    add(smoothed(by_points, samples), points);
    add(smoothed(by_jacobians, samples), jacobians);
  }
  const boost::math::chi_squared distribution(3 * runs);
  const double low = boost::math::quantile(distribution, 0.005) / runs;
  const double high = boost::math::quantile(boost::math::complement(distribution, 0.005)) / runs;
  std::printf("smoothed: mean NEES of 3, %d runs, 99 %% band %.2f to %.2f\n  second  Jacobians  points\n", runs, low,
              high);
  double of_points = 0, of_jacobians = 0;  // beyond 3
  for (std::size_t k = 0; k < points.size(); ++k) {
    std::printf("  %zu  %.2f  %.2f\n", k, jacobians[k], points[k]);
    CHECK(points[k] > low);
    CHECK(points[k] < jacobians[k]);
    CHECK(jacobians[k] > high);
    of_points += points[k] - 3;
    of_jacobians += jacobians[k] - 3;
  }
  // Not in the band everywhere: what the regression leaves is added as if it were new in each step.
  CHECK(of_points < 0.5 * of_jacobians);
}

}  // namespace unscented_propagation_test
