// SPDX-License-Identifier: Apache-2.0
// The estimator by itself: a step and a sample in their parts, against the textbook.
#include "filter/estimator.hpp"

#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/composition.hpp"
#include "catch.hpp"
#include "compose/composition_plan.hpp"

namespace estimator_test {

using namespace binnacle;
using namespace binnacle::internal::filter;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Position and velocity on a line; the position is measured.
std::shared_ptr<const Composition> line() {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  return Composition::parse(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"position": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2},
                 "velocity": {"type": "vector", "size": 1, "unit": "m/s", "init": 0.5, "sigma": 0.3}},
      "process": {"move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
                  "wander": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": 0.2}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "position"},
                               "sigma": [0.7], "gate": 0.99, "recover": {"after": 1, "inflate": {"position.x": "3 m"}}}}}}})",
                            "line.json");
}

struct Fixture {
  Fixture() {
    const auto& layout = composition->plan().layout;
    memory.resize(layout.size() + Layout::alignment);
    void* begin = memory.data();
    std::size_t space = memory.size();
    arena = static_cast<std::byte*>(std::align(Layout::alignment, layout.size(), begin, space));
    calls = std::make_unique<ModelCalls>();
    estimator = std::make_unique<Estimator>(plan(), composition->plan().channels, arena, *calls);
    estimator->reset();
    estimator->start(false);
  }
  const FilterPlan& plan() const { return composition->plan().filters[0]; }
  const MeasurementPlan& fix() const { return plan().measurements[0]; }
  MatrixXd P() const { return estimator->covariance().as(); }
  Result linearize(double z) {
    SampleView sample;
    sample.t = 0;
    sample.fields = &z;
    return estimator->linearize(fix(), sample, {0, nullptr});
  }

  std::shared_ptr<const Composition> composition = line();
  std::vector<std::byte> memory;
  std::byte* arena = nullptr;
  std::unique_ptr<ModelCalls> calls;
  std::unique_ptr<Estimator> estimator;
};

const MatrixXd P0 = Eigen::Vector2d(4, 0.09).asDiagonal();

}  // namespace

TEST_CASE("an estimator starts with the values and variances of the config") {
  Fixture f;
  CHECK(f.estimator->state()[0] == 1);
  CHECK(f.estimator->state()[1] == 0.5);
  CHECK((f.P() - P0).norm() < 1e-15);
}

TEST_CASE("a step in its parts: models, then P, then x") {
  Fixture f;
  f.estimator->propagate({0, nullptr}, nanoseconds(2), {});
  CHECK(f.estimator->state()[0] == 1);
  CHECK((f.P() - P0).norm() < 1e-15);
  CHECK(std::abs(f.estimator->x_plus()[0] - 2) < 1e-15);
  f.estimator->predict(nanoseconds(2));
  MatrixXd Phi = MatrixXd::Identity(2, 2), Qd(2, 2);
  Phi(0, 1) = 2;
  Qd << 8.0 / 3, 2, 2, 2;
  CHECK((f.P() - (Phi * P0 * Phi.transpose() + 0.04 * Qd)).norm() < 1e-14);
  CHECK(f.estimator->state()[0] == 1);
  f.estimator->advance();
  CHECK(std::abs(f.estimator->state()[0] - 2) < 1e-15);
}

TEST_CASE("a sample in its parts: linearizing and judging change nothing, correcting does") {
  Fixture f;
  REQUIRE(f.linearize(3));
  const auto& rows = f.estimator->rows();
  CHECK(rows.m == 1);
  CHECK(rows.r[0] == 2);
  CHECK(rows.H[0] == 1);
  CHECK(rows.R_nominal[0] == 0.7 * 0.7);
  const Judgement judged = f.estimator->judge(f.fix(), 0, 0, false);
  CHECK(judged.outcome == Outcome::accepted);
  const double S = 4 + 0.49;
  CHECK(std::abs(rows.nis - 4 / S) < 1e-15);
  CHECK(f.estimator->state()[0] == 1);
  CHECK((f.P() - P0).norm() < 1e-15);

  f.estimator->correct(f.fix());
  CHECK(std::abs(f.estimator->state()[0] - (1 + 4 / S * 2)) < 1e-14);
  CHECK(std::abs(f.P()(0, 0) - 4 * 0.49 / S) < 1e-14);
  CHECK(std::abs(f.P()(1, 1) - 0.09) < 1e-16);
  CHECK_FALSE(f.estimator->has_reset());
}

TEST_CASE("a sample is judged: beyond the gate, withheld, refused, and P is opened by what is named") {
  Fixture f;
  REQUIRE(f.linearize(100));
  CHECK(f.estimator->judge(f.fix(), 0, 0, false).outcome == Outcome::gated);
  CHECK(f.estimator->rows().nis > 6.63);
  REQUIRE(f.linearize(100));
  CHECK(f.estimator->judge(f.fix(), 0, 0, true).outcome == Outcome::withheld);
  CHECK(f.linearize(std::nan("")).refusal == Refusal::invalid);
  CHECK((f.P() - P0).norm() < 1e-15);
  f.estimator->inflate(f.fix());
  CHECK((f.P() - P0 - MatrixXd(Eigen::Vector2d(9, 0).asDiagonal())).norm() < 1e-14);
}

TEST_CASE("a state that is not finite and a variance that is negative are named") {
  Fixture f;
  f.estimator->check_update(0);
  double* const x = f.plan().state.in(f.arena);
  const double kept = x[1];
  x[1] = std::nan("");
  CHECK_THROWS_WITH(f.estimator->check_update(nanoseconds(3)), "block 'velocity' is not finite at 3 s");
  x[1] = kept;
  f.plan().covariance.in(f.arena)[0] = -1;
  CHECK_THROWS_WITH(f.estimator->check_update(nanoseconds(3)), "'position.x' has the variance -1 at 3 s");
}

}  // namespace estimator_test
