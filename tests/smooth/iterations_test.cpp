// SPDX-License-Identifier: Apache-2.0
// Iterations about the smoothed path against Gauss and Newton over all states at once, in long double.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <unistd.h>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "binnacle/run.hpp"
#include "catch.hpp"
#include "line.hpp"
#include "smooth/interval_smoother.hpp"

namespace iterations_test {

using namespace binnacle;
using filter_tests::composition_of;

namespace {

using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

constexpr int count = 60;
constexpr double period = 0.5, q = 0.09, sigma = 1.0;
const Eigen::Vector2d initial(1.5, 1.0), initial_sigma(1.0, 1.0);

struct Epochs {
  std::vector<Vector> x;
  std::vector<Matrix> P;
  smooth::Iterations iterations;
};

/// Smooths a run, each estimate.
class Smoothed final : public RunObserver {
 public:
  Smoothed(int iterations, std::int64_t length) : iterations_(iterations), length_(length) {}
  void begin(Session& session) override {
    session_ = &session;
    smoother_ = std::make_unique<smooth::IntervalSmoother>(session, length_);
    filter_ = std::make_unique<smooth::SmoothedFilter>(session, 0, iterations_);
  }
  void after_instant() override { smoother_->after_instant(); }
  void finished() override {
    std::vector<std::byte> before(session_->snapshot_size()), after(before.size());
    session_->snapshot(before);
    const auto mark = [&](smooth::SmoothedFilter& filter) {
      if (session_->time({0}) == last_) return;
      last_ = session_->time({0});
      filter.mark();
    };
    const auto sweep = [&](smooth::SmoothedFilter& filter) {
      last_ = no_time;
      filter.sweep(
          [&](const smooth::Epoch& epoch) {
            epochs.x.insert(epochs.x.begin(), Eigen::Map<const Eigen::Vector2d>(epoch.x).cast<long double>());
            epochs.P.insert(epochs.P.begin(), epoch.P.as().cast<long double>());
          },
          [](smooth::WithheldSample) {});
    };
    smoother_->run_back({{filter_.get()}, mark, sweep, [&](smooth::SmoothedFilter&) { epochs = {}; }});
    epochs.iterations = filter_->iterations();
    session_->snapshot(after);
    CHECK((before == after));
  }
  Epochs epochs;

 private:
  int iterations_;
  std::int64_t length_;
  Time last_ = no_time;
  Session* session_ = nullptr;
  std::unique_ptr<smooth::IntervalSmoother> smoother_;
  std::unique_ptr<smooth::SmoothedFilter> filter_;
};

/// x walks at random; measured are x₀² and x₀ x₁, here and there an outlier.
struct Problem {
  explicit Problem(unsigned seed)
      : path(std::filesystem::temp_directory_path() / ("smooth" + std::to_string(getpid()))) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::ofstream file(path);
    file.precision(17);
    file << "t,z0,z1\n";
    Eigen::Vector2d x(2.5, -0.5);
    for (int k = 0; k < count; ++k) {
      if (k > 0)
        for (double& value : x) value += std::sqrt(q * period) * normal(random);
      z.emplace_back(x[0] * x[0] + sigma * normal(random), x[0] * x[1] + sigma * normal(random));
      if (k % 13 == 7) z.back()[0] += 200;
      file << period * k << ',' << z.back()[0] << ',' << z.back()[1] << '\n';
    }
  }
  ~Problem() { std::filesystem::remove(path); }

  Epochs smoothed(int iterations, std::int64_t length = 4096, const std::string& extra = "") const {
    const auto composition = composition_of(R"({"binnacle": 1,
      "sources": {"z": {"type": "csv", "path": ")" +
                                            path.string() + R"(", "time": {"column": "t"},
                        "columns": {"z0": {"column": "z0", "unit": "m^2"}, "z1": {"column": "z1", "unit": "m^2"}}}},
      "filters": {"f": {
        "blocks": {"x": {"type": "vector", "size": 2, "unit": "m", "init": [1.5, 1], "sigma": 1)" +
                                            extra + R"(}},
        "process": {"wander": {"type": "random_walk", "blocks": {"x": "x"}, "q": 0.3}},
        "derived": {"seen": {"type": "square", "blocks": {"x": "x"}}},
        "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "seen"}, "sigma": [1],
                                 "gate": {"probability": 0.999999, "by": "row"}, "recover": false}}}}})");
    Smoothed observer(iterations, length);
    RunOptions options;
    options.observer = &observer;
    const RunResult result = run(composition, options);
    INFO(result.failures.text());
    CHECK(result.failures.empty());
    return observer.epochs;
  }

  /// One step of Gauss and Newton from x, over all states at once; returns the covariance.
  Matrix step(std::vector<Vector>& x) const {
    const int n = 2;
    Matrix N = Matrix::Zero(n * count, n * count);
    Vector b = Vector::Zero(n * count);
    for (int k = 0; k < count; ++k) {
      const auto at = n * k;
      const long double a = x[static_cast<std::size_t>(k)][0], c = x[static_cast<std::size_t>(k)][1];
      Matrix H(2, 2);
      H << 2 * a, 0, c, a;
      const Eigen::Vector2d& seen = z[static_cast<std::size_t>(k)];
      Vector r(2);
      r << seen[0] - a * a, seen[1] - a * c;
      const int first = k % 13 == 7 ? 1 : 0;  // the outlier is left out
      const Matrix J = H.bottomRows(2 - first);
      N.block(at, at, n, n) += J.transpose() * J / (sigma * sigma);
      b.segment(at, n) += J.transpose() * r.tail(2 - first) / (sigma * sigma);
      if (k == 0) {
        const Vector d = initial.cast<long double>() - x[0];
        N.block(0, 0, n, n) += Matrix::Identity(n, n);
        b.segment(0, n) += d;
        continue;
      }
      const long double w = 1 / (static_cast<long double>(q) * period);
      const Vector d = x[static_cast<std::size_t>(k)] - x[static_cast<std::size_t>(k - 1)];
      Matrix D(n, 2 * n);
      D << -Matrix::Identity(n, n), Matrix::Identity(n, n);
      N.block(at - n, at - n, 2 * n, 2 * n) += w * D.transpose() * D;
      b.segment(at - n, 2 * n) -= w * D.transpose() * d;
    }
    const Matrix covariance = N.inverse();
    const Vector delta = covariance * b;
    for (int k = 0; k < count; ++k) x[static_cast<std::size_t>(k)] += delta.segment(n * k, n);
    return covariance;
  }

  std::filesystem::path path;
  std::vector<Eigen::Vector2d> z;
};

}  // namespace

TEST_CASE("an iteration is one step of Gauss and Newton over all states at once") {
  const Problem problem(3);
  std::vector<Vector> x = problem.smoothed(0).x;
  REQUIRE(x.size() == count);
  for (int iterations = 1; iterations <= 3; ++iterations) {
    const Matrix covariance = problem.step(x);
    const Epochs epochs = problem.smoothed(iterations);
    INFO(iterations << ", change " << epochs.iterations.change);
    REQUIRE(epochs.iterations.done == iterations);
    REQUIRE(epochs.x.size() == count);
    double worst = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const Matrix P = covariance.block(2 * static_cast<Eigen::Index>(k), 2 * static_cast<Eigen::Index>(k), 2, 2);
      worst = std::max(worst, static_cast<double>((epochs.x[k] - x[k]).norm() / x[k].norm()));
      worst = std::max(worst, static_cast<double>((epochs.P[k] - P).norm() / P.norm()));
    }
    CHECK(worst < 1e-10);
  }
}

TEST_CASE("iterations end where the path stands still, and their number is reported") {
  const Problem problem(3);
  const Epochs epochs = problem.smoothed(50);
  INFO(epochs.iterations.change);
  CHECK(epochs.iterations.converged);
  CHECK(epochs.iterations.done > 2);
  CHECK(epochs.iterations.done < 50);
  CHECK(epochs.iterations.change < 1e-3);
  CHECK_FALSE(problem.smoothed(1).iterations.converged);
}

TEST_CASE("iterations are the same to the bit for any number of snapshots") {
  const Problem problem(4);
  const Epochs whole = problem.smoothed(3), parts = problem.smoothed(3, 7);
  REQUIRE(whole.x.size() == parts.x.size());
  for (std::size_t k = 0; k < whole.x.size(); ++k) {
    CHECK(whole.x[k] == parts.x[k]);
    CHECK(whole.P[k] == parts.P[k]);
  }
}

}  // namespace iterations_test
