// SPDX-License-Identifier: Apache-2.0
// What the engine does, against dense textbook filters written out here.
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace engine_test {

using namespace binnacle;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using filter_tests::line;
using filter_tests::push;
using filter_tests::session_of;

namespace {

MatrixXd dense(ConstMatrixView view) { return view.as(); }

/// The same filter, dense.
struct DenseLine {
  VectorXd x = (VectorXd(2) << 1, 0.5).finished();
  MatrixXd P = Eigen::Vector2d(4, 0.09).asDiagonal();
  void advance(double dt) {
    MatrixXd Phi = MatrixXd::Identity(2, 2);
    Phi(0, 1) = dt;
    const double q = 0.04;
    MatrixXd Q(2, 2);
    Q << q * dt * dt * dt / 3, q * dt * dt / 2, q * dt * dt / 2, q * dt;
    x = Phi * x;
    P = Phi * P * Phi.transpose() + Q;
  }
  double update(double z, double R, bool considers_velocity = false) {
    const Eigen::RowVector2d H(1, 0);
    const double S = H * P * H.transpose() + R;
    VectorXd K = P * H.transpose() / S;
    if (considers_velocity) K(1) = 0;
    const double r = z - x(0);
    x += K * r;
    const MatrixXd A = MatrixXd::Identity(2, 2) - K * H;
    P = A * P * A.transpose() + K * R * K.transpose();
    return r * r / S;
  }
};

void require_equal(Session& filter, const DenseLine& expected) {
  double position = 0, velocity = 0;
  filter.read(filter.block("position"), {&position, 1});
  filter.read(filter.block("velocity"), {&velocity, 1});
  REQUIRE(std::abs(position - expected.x(0)) < 1e-12);
  REQUIRE(std::abs(velocity - expected.x(1)) < 1e-12);
  REQUIRE((dense(filter.covariance(FilterId{0})) - expected.P).norm() < 1e-12 * expected.P.norm());
}

}  // namespace

TEST_CASE("a composed filter equals the dense one: joint discretization, update, ledger") {
  Session filter = session_of(line());
  DenseLine expected;
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  double t = 0, nis = 0;
  const int samples = 60;
  for (int i = 0; i < samples; ++i) {
    const double dt = 0.1 + 0.05 * (i % 4);
    const double z = 1 + 0.5 * t + normal(engine);
    if (i > 0) {
      t += dt;
      expected.advance(seconds(nanoseconds(t)) - static_cast<double>(filter.time(FilterId{0})) * 1e-9);
    }
    nis += expected.update(z, 0.49);
    push(filter, "z", t, {z});
  }
  require_equal(filter, expected);
  const auto counts = filter.counts({{0}, 0});
  REQUIRE(counts.offered == samples);
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::accepted)] == samples);
  REQUIRE(std::abs(counts.nis_mean - nis / samples) < 1e-10);
  REQUIRE(counts.dof_mean == 1);
}

TEST_CASE("a considered component widens the covariance and is never corrected") {
  Session filter = session_of(line("", "", R"(, "consider": ["x"])"));
  DenseLine expected;
  for (int i = 0; i < 20; ++i) {
    if (i > 0) expected.advance(0.5);
    expected.update(2.0 + i, 0.49, true);
    push(filter, "z", 0.5 * i, {2.0 + i});
  }
  require_equal(filter, expected);
  REQUIRE(expected.x(1) == 0.5);
}

TEST_CASE("a frozen component has no row in P but still moves others") {
  Session filter = session_of(line("", "", R"(, "estimate": [])"));
  push(filter, "z", 0, {1.0});
  push(filter, "z", 2, {1.0});
  REQUIRE(filter.covariance(FilterId{0}).rows == 1);
  // Advanced by the frozen 0.5 m/s for 2 s, variance untouched by the missing process noise.
  const double P0 = 1 / (1 / 4.0 + 1 / 0.49);
  double position = 0;
  filter.read(filter.block("position"), {&position, 1});
  const double K = P0 / (P0 + 0.49);
  REQUIRE(std::abs(position - (2.0 + K * (1.0 - 2.0))) < 1e-12);
  double velocity = 0;
  filter.read(filter.block("velocity"), {&velocity, 1});
  REQUIRE(velocity == 0.5);
}

TEST_CASE("a frozen component's own noise does not leak, and hold stops its motion") {
  const auto config = [](const char* hold) {
    return std::string(R"({"binnacle": 1,
      "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
      "filters": {"f": {
        "blocks": {"x": {"type": "vector", "size": 3, "unit": "m", "init": [1, 2, 3], "sigma": 1, "estimate": ["x", "z"])") +
           hold + R"(}},
        "process": {"decay": {"type": "gauss_markov", "blocks": {"x": "x"}, "tau": "1 s", "sigma": 1}},
        "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"},
                                 "H": [[1, 1, 1]], "sigma": [0.1]}}}}})";
  };
  Session free = session_of(config(""));
  Session held = session_of(config(R"(, "hold": true)"));
  for (Session* filter : {&free, &held}) {
    push(*filter, "z", 0, {6.0});
    push(*filter, "z", 1, {6 * std::exp(-1.0)});
  }
  double x[3];
  free.read(free.block("x"), x);
  REQUIRE(std::abs(x[1] - 2 * std::exp(-1.0)) < 1e-15);
  held.read(held.block("x"), x);
  REQUIRE(x[1] == 2);
  REQUIRE(free.covariance(FilterId{0}).rows == 2);
  REQUIRE(std::abs(free.covariance(FilterId{0})(0, 1) - free.covariance(FilterId{0})(1, 0)) == 0);
}

TEST_CASE("late samples are refused and counted") {
  Session filter = session_of(line());
  push(filter, "z", 1, {1});
  push(filter, "z", 2, {1});
  push(filter, "z", 1.5, {1});
  const auto counts = filter.counts({{0}, 0});
  REQUIRE(counts.offered == 3);
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::late)] == 1);
  REQUIRE(filter.time(FilterId{0}) == nanoseconds(2));
}

TEST_CASE("withheld samples are predicted but leave no trace in the estimate") {
  Session all = session_of(line());
  Session some = session_of(line("", R"(, "withhold": {"every": 2})"));
  Session window = session_of(line("", R"(, "withhold": [["1 s", "2 s"], ["start+4 s", "start+5 s"]])"));
  DenseLine expected;
  for (int i = 0; i < 8; ++i) {
    for (Session* filter : {&all, &some, &window}) push(*filter, "z", i, {1.0 + i});
    if (i > 0) expected.advance(1);
    if (i % 2 == 0) expected.update(1.0 + i, 0.49);
  }
  require_equal(some, expected);
  REQUIRE(some.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::withheld)] == 4);
  REQUIRE(window.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::withheld)] == 4);
  REQUIRE(window.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::accepted)] == 4);
}

TEST_CASE("the gate keeps outliers out, and recovery reopens a filter that locks a sensor out") {
  Session filter =
      session_of(line("", R"(, "gate": 0.99, "recover": {"after": 3, "inflate": {"position.x": "1 km"}})"));
  for (int i = 0; i < 20; ++i) push(filter, "z", 0.1 * i, {1.0});
  for (int i = 20; i < 23; ++i) push(filter, "z", 0.1 * i, {500.0});
  auto counts = filter.counts({{0}, 0});
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::gated)] == 3);
  REQUIRE(counts.recoveries == 1);
  REQUIRE(counts.last_reason == "NIS beyond the gate");
  push(filter, "z", 2.3, {500.0});
  REQUIRE(filter.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::accepted)] == 21);
  double position = 0;
  filter.read(filter.block("position"), {&position, 1});
  REQUIRE(std::abs(position - 500) < 1);
}

TEST_CASE("refusals are typed, and a refused sample's memory is rolled back") {
  Session filter = session_of(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z": {"unit": "1"}}}},
    "filters": {"f": {"blocks": {"x": {"type": "vector", "size": 1, "sigma": 1}},
      "process": {"keep": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"picky": {"type": "picky", "channel": "z", "blocks": {"x": "x"}}}}}})");
  push(filter, "z", 0, {1});    // R = 1
  push(filter, "z", 1, {-1});   // unsupported
  push(filter, "z", 2, {101});  // invalid
  push(filter, "z", 3, {50});   // residual NaN
  push(filter, "z", 4, {std::nan("")});
  const auto counts = filter.counts({{0}, 0});
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::unsupported)] == 1);
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::invalid)] == 3);
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::accepted)] == 1);
  push(filter, "z", 5, {1});  // its memory counts accepted samples only: R = 2
  REQUIRE(std::abs(filter.covariance(FilterId{0})(0, 0) - 1 / (1 + 1 + 0.5)) < 1e-15);
}

TEST_CASE("a noise estimator's memory is rolled back when its sample is gated, unless it learns from gated ones") {
  const auto variance_after = [](const char* noise) {
    Session filter = session_of(line("", std::string(R"(, "gate": 0.9999, "noise": )") + noise));
    push(filter, "z", 0, {1});
    push(filter, "z", 0, {1e4});  // gated
    push(filter, "z", 0, {1});
    return filter.covariance(FilterId{0})(0, 0);
  };
  const auto after = [](double R1, double R2) { return 1 / (1 / 4.0 + 1 / R1 + 1 / R2); };
  REQUIRE(std::abs(variance_after(R"({"type": "counting"})") - after(0.49, 2 * 0.49)) < 1e-14);
  REQUIRE(std::abs(variance_after(R"({"type": "counting", "learn_from_gated": true})") - after(0.49, 3 * 0.49)) <
          1e-14);
}

TEST_CASE("a stack is one update: the same as its parts one after the other when their noise is independent") {
  const std::string head = R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"a": {"unit": "m"}, "b": {"unit": "m/s"}}}},
    "filters": {"f": {
      "blocks": {"p": {"type": "vector", "size": 1, "unit": "m", "sigma": 2},
                 "v": {"type": "vector", "size": 1, "unit": "m/s", "sigma": 1}},
      "process": {"move": {"type": "integrated", "blocks": {"x": "p", "rate": "v"}},
                  "wander": {"type": "random_walk", "blocks": {"x": "v"}, "q": 0.2}},
      "measurements": )";
  const std::string p = R"("type": "linear_measurement", "blocks": {"x": "p"}, "fields": {"z0": "a"}, "sigma": [0.5])";
  const std::string v = R"("type": "linear_measurement", "blocks": {"x": "v"}, "fields": {"z0": "b"}, "sigma": [0.1])";
  Session stacked =
      session_of(head + R"({"both": {"channel": "z", "stack": {"p": {)" + p + R"(}, "v": {)" + v + "}}}}}}}");
  Session apart = session_of(head + R"({"p": {"channel": "z", )" + p + R"(}, "v": {"channel": "z", )" + v + "}}}}}");
  for (int i = 0; i < 10; ++i)
    for (Session* filter : {&stacked, &apart}) push(*filter, "z", i, {0.3 * i, 0.3});
  REQUIRE((dense(stacked.covariance(FilterId{0})) - dense(apart.covariance(FilterId{0}))).norm() < 1e-13);
  REQUIRE(std::abs(stacked.state(FilterId{0})[0] - apart.state(FilterId{0})[0]) < 1e-12);
  REQUIRE(stacked.counts({{0}, 0}).dof_mean == 2);
}

namespace {

/// The newest measurement.
class KeepRecord : public StepObserver {
 public:
  Wants wants() const override { return Wants::everything; }
  void offered(const UpdateRecord& record) override {
    S = dense(record.S);
    H = dense(record.H);
    if (record.P0) P = dense(record.P0);
    r = Eigen::Map<const VectorXd>(record.residual, record.rows);
  }
  MatrixXd S, H, P;
  VectorXd r;
};

}  // namespace

TEST_CASE("Jacobians are chained through derived blocks of derived blocks") {
  Session filter = session_of(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m^2"}, "z1": {"unit": "m^2"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 2, "unit": "m", "init": [1.3, -0.4], "sigma": [0.1, 0.2]}},
      "derived": {"twice": {"type": "square", "blocks": {"x": "once"}},
                  "once": {"type": "square", "blocks": {"x": "x"}}},
      "process": {"keep": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"see": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "twice"}, "sigma": [1]}}}}})");
  KeepRecord observer;
  filter.attach({0}, &observer);
  push(filter, "z", 0, {0, 0});
  const auto h = [](double a, double b) { return Eigen::Vector2d(a * a * a * a, a * a * a * b); };
  const double e = 1e-6;
  Eigen::Matrix2d H;
  H.col(0) = (h(1.3 + e, -0.4) - h(1.3 - e, -0.4)) / (2 * e);
  H.col(1) = (h(1.3, -0.4 + e) - h(1.3, -0.4 - e)) / (2 * e);
  const Eigen::Matrix2d expected =
      H * Eigen::Vector2d(0.01, 0.04).asDiagonal() * H.transpose() + Eigen::Matrix2d::Identity();
  REQUIRE((observer.S - expected).norm() < 1e-8);
  REQUIRE((observer.r + h(1.3, -0.4)).norm() < 1e-12);
}

TEST_CASE("the observer's H has a column per row of P: chained through derived blocks, zero where nothing is seen") {
  // Rows of P: idle 0; x 1, 2; offset 3, 4. With "estimate" of one component of x, that column alone.
  const auto recorded = [](const std::string& more_of_x, const std::string& withheld) {
    Session filter = session_of(R"({"binnacle": 1,
      "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m^2"}, "z1": {"unit": "m^2"}}}},
      "filters": {"f": {
        "blocks": {"idle": {"type": "vector", "size": 1, "unit": "m", "sigma": 3},
                   "x": {"type": "vector", "size": 2, "unit": "m", "init": [1.3, -0.4], "sigma": [0.1, 0.2])" +
                                more_of_x + R"(},
                   "offset": {"type": "vector", "size": 2, "unit": "m^2", "sigma": [0.5, 0.6]}},
        "derived": {"squared": {"type": "square", "blocks": {"x": "x"}}},
        "process": {"of_idle": {"type": "random_constant", "blocks": {"x": "idle"}},
                    "of_x": {"type": "random_constant", "blocks": {"x": "x"}},
                    "of_offset": {"type": "random_constant", "blocks": {"x": "offset"}}},
        "measurements": {"see": {"type": "linear_measurement", "channel": "z", "H": [[1, 0], [2, 1]], "sigma": [0.7],
                                 "blocks": {"x": "squared", "bias": "offset"})" +
                                withheld + R"(}}}}})");
    KeepRecord observer;
    filter.attach({0}, &observer);
    push(filter, "z", 0, {0.3, 0.2});
    return observer;
  };
  const auto h = [](double a, double b) {
    const Eigen::Vector2d squared(a * a, a * b);  // as the plugin `probe` has it
    return Eigen::Vector2d(squared[0], 2 * squared[0] + squared[1]);
  };
  const double e = 1e-6;
  MatrixXd expected = MatrixXd::Zero(2, 5);
  expected.col(1) = (h(1.3 + e, -0.4) - h(1.3 - e, -0.4)) / (2 * e);
  expected.col(2) = (h(1.3, -0.4 + e) - h(1.3, -0.4 - e)) / (2 * e);
  expected.rightCols(2).setIdentity();

  const KeepRecord all = recorded("", "");
  REQUIRE(all.H.rows() == 2);
  REQUIRE(all.H.cols() == 5);
  REQUIRE((all.H - expected).norm() < 1e-8);
  REQUIRE((all.S - all.H * all.P * all.H.transpose() - 0.49 * Eigen::Matrix2d::Identity()).norm() < 1e-12);

  const KeepRecord some = recorded(R"(, "estimate": ["x1"])", "");
  REQUIRE(some.H.cols() == 4);
  REQUIRE((some.H.col(0)).norm() == 0);
  REQUIRE((some.H.rightCols(3) - expected.rightCols(3)).norm() < 1e-8);

  // What is withheld has been linearized as well.
  REQUIRE((recorded("", R"(, "withhold": {"every": 1})").H - expected).norm() < 1e-8);
}

TEST_CASE("a filter that breaks stops with a diagnosis and never shows NaN as an estimate") {
  const auto config = [](const char* more) {
    return std::string(R"({"binnacle": 1,
      "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "1"}}}},
      "filters": {"f": {"blocks": {"x": {"type": "vector", "size": 1, "sigma": 1}},
        "process": {"bad": {"type": "breaking", "blocks": {"x": "x"}, "after": "2 s")") +
           more + R"(}},
        "measurements": {"see": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [1]}}}}})";
  };
  for (const char* more : {"", R"(, "politely": true)"}) {
    Session filter = session_of(config(more));
    for (int t = 0; t <= 4; ++t) push(filter, "z", t, {1});
    REQUIRE_FALSE(filter.healthy(FilterId{0}));
    REQUIRE(filter.diagnosis(FilterId{0}) ==
            (*more ? "process 'bad' cannot continue at 3 s: it is too late"
                   : "block 'x' is not finite at 3 s: plugin 'probe', component 'breaking' (/filters/f/process/bad): "
                     "propagate at 3 s gave 'x', which is not finite"));
    REQUIRE(filter.counts({{0}, 0}).by_outcome[0] == 3);
  }
}

}  // namespace engine_test
