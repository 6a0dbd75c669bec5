// SPDX-License-Identifier: Apache-2.0
// Smoothed estimates of composed linear filters against three oracles in long double: Rauch, Tung and Striebel; one dense
// least squares over all states; and, where gains are not optimal, the joint error through the gains that were used.
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "catch.hpp"
#include "line.hpp"
#include "smooth/interval_smoother.hpp"

using namespace binnacle;
using filter_tests::composition_of;
using filter_tests::push;

namespace {

using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

Matrix wide(ConstMatrixView A) { return A.as().cast<long double>(); }
Vector wide(const double* x, int n) { return Eigen::Map<const Eigen::VectorXd>(x, n).cast<long double>(); }

struct Event {
  enum Kind { step, update, variances } kind = step;
  Matrix Phi, Q;      // of a step
  Matrix H, K, S, R;  // of an update
  Vector r;           // its residual
  Vector x0, x1;      // before and after
  Matrix P0, P1;
};

/// Keeps the whole log for an oracle, and hands it to the smoother.
class Log final : public StepObserver {
 public:
  explicit Log(smooth::Stretch& next) : next_(next) {}
  Wants wants() const override { return Wants::everything; }
  void started(Time t, const double* x, ConstMatrixView P) override {
    n = P.rows;
    x_first = wide(x, n), P_first = wide(P);
    next_.started(t, x, P);
  }
  void stepped(const StepRecord& record) override {
    Event event;
    event.Phi = wide(record.Phi), event.Q = wide(record.Qd);
    event.x0 = wide(record.x0, n), event.x1 = wide(record.x1, n);
    event.P0 = wide(record.P0), event.P1 = wide(record.P1);
    events.push_back(std::move(event));
    next_.stepped(record);
  }
  void offered(const UpdateRecord& record) override {
    ++outcomes[static_cast<int>(record.outcome)];
    left_out += record.left_out;
    if (record.outcome == Outcome::accepted) {
      Event event;
      event.kind = Event::update;
      event.H = wide(record.H), event.K = wide(record.K), event.S = wide(record.S), event.R = wide(record.R);
      event.r = wide(record.residual, record.rows);
      event.x0 = wide(record.x0, n), event.x1 = wide(record.x1, n);
      event.P0 = wide(record.P0), event.P1 = wide(record.P1);
      events.push_back(std::move(event));
    }
    next_.offered(record);
  }
  void inflated(const InflationRecord& record) override { next_.inflated(record); }

  int n = 0;
  Vector x_first;
  Matrix P_first;
  std::vector<Event> events;
  std::map<int, int> outcomes;
  int left_out = 0;

 private:
  smooth::Stretch& next_;
};

/// What the smoother and the filter's log say of one state, after each instant.
struct Smoothed {
  std::size_t events = 0;  // of the log before it
  Vector x;
  Matrix P;
};

struct Case {
  Case(const std::string& config, int seed) : session(composition_of(config)), random(static_cast<unsigned>(seed)) {
    filter = std::make_unique<smooth::SmoothedFilter>(session, 0);
    log = std::make_unique<Log>(filter->stretch());
    session.attach({0}, log.get());
  }
  double normal() { return std::normal_distribution<double>()(random); }
  void mark() {
    filter->mark();
    places.push_back(log->events.size());
  }
  std::vector<Smoothed> smoothed() {
    std::vector<Smoothed> all;
    filter->sweep(
        [&](const smooth::Epoch& epoch) {
          all.insert(all.begin(), {places[places.size() - 1 - all.size()], wide(epoch.x, log->n), wide(epoch.P)});
        },
        [](smooth::WithheldSample) {});
    REQUIRE(all.size() == places.size());
    return all;
  }

  Session session;
  std::mt19937 random;
  std::unique_ptr<smooth::SmoothedFilter> filter;
  std::unique_ptr<Log> log;
  std::vector<std::size_t> places;
};

/// A chain of blocks of random sizes: a position that a velocity moves, a drift, a constant of which a part is frozen; by
/// `extra`, keys of the drift.
std::string chain(std::mt19937& random, const std::string& extra = "") {
  const auto between = [&](double low, double high) {
    return std::to_string(std::uniform_real_distribution<double>(low, high)(random));
  };
  const bool by_row = random() % 2;
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}},
                "y": {"type": "pushed", "fields": {"z0": {"unit": "m/s"}}}},
    "filters": {"f": {
      "blocks": {
        "x": {"type": "vector", "size": 2, "unit": "m", "init": [1, -1], "sigma": )" +
         between(1, 5) + R"(},
        "v": {"type": "vector", "size": 2, "unit": "m/s", "init": [0.1, 0], "sigma": )" +
         between(0.1, 1) + R"(},
        "d": {"type": "vector", "size": 2, "unit": "m", "sigma": )" +
         between(0.5, 2) + extra + R"(},
        "c": {"type": "vector", "size": 2, "unit": "m", "init": [0.2, 0], "sigma": [0.3, 0.4], "estimate": ["x1"]}},
      "process": {
        "move": {"type": "integrated", "blocks": {"x": "x", "rate": "v"}},
        "wander": {"type": "random_walk", "blocks": {"x": "v"}, "q": )" +
         between(0.05, 0.5) + R"(},
        "drift": {"type": "gauss_markov", "blocks": {"x": "d"}, "tau": ")" +
         between(5, 30) + R"( s", "sigma": )" + between(0.3, 1) + R"(},
        "stay": {"type": "random_constant", "blocks": {"x": "c"}}},
      "measurements": {
        "both": {"channel": "z", "gate": {"probability": 0.99, "by": ")" +
         std::string(by_row ? "row" : "sample") + R"("}, "recover": false, "stack": {
          "p": {"type": "linear_measurement", "blocks": {"x": "x"}, "sigma": [0.4, 0.5]},
          "q": {"type": "linear_measurement", "blocks": {"x": "d"}, "sigma": [0.3, 0.6]}}},
        "speed": {"type": "linear_measurement", "channel": "y", "blocks": {"x": "v"}, "H": [[1, 0.5]], "sigma": [0.2]}}}}})";
}

/// Uneven times, several samples of an instant, outliers.
void drive(Case& test, int count) {
  double t = 0;
  for (int k = 0; k < count; ++k) {
    t += 0.2 + 0.1 * (k % 3);
    const double outlier = k % 11 == 5 ? 30 : 0;
    if (k % 2 == 0) push(test.session, "y", t, {0.1 * test.normal()});
    if (k % 5 != 1) push(test.session, "z", t, {1 + test.normal() + outlier, -1 + test.normal()});
    if (test.session.started({0})) test.mark();
  }
}

/// Rauch, Tung, Striebel (1965): backwards from filtered and predicted states.
std::vector<Smoothed> rts(const Log& log, const std::vector<std::size_t>& places) {
  std::vector<Vector> x(log.events.size() + 1);
  std::vector<Matrix> P(log.events.size() + 1);
  x.back() = log.events.back().x1;
  P.back() = log.events.back().P1;
  for (std::size_t k = log.events.size(); k-- > 0;) {
    const Event& event = log.events[k];
    if (event.kind == Event::update) {
      // One instant: smoothed before an update is smoothed after it.
      x[k] = x[k + 1], P[k] = P[k + 1];
      continue;
    }
    const Matrix C = event.P1.ldlt().solve(event.Phi * event.P0).transpose();
    x[k] = event.x0 + C * (x[k + 1] - event.x1);
    P[k] = event.P0 + C * (P[k + 1] - event.P1) * C.transpose();
  }
  std::vector<Smoothed> all;
  for (const std::size_t place : places) all.push_back({place, x[place], P[place]});
  return all;
}

double difference(const std::vector<Smoothed>& a, const std::vector<Smoothed>& b) {
  REQUIRE(a.size() == b.size());
  long double worst = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    worst = std::max(worst, (a[k].x - b[k].x).norm() / (1 + b[k].x.norm()));
    worst = std::max(worst, (a[k].P - b[k].P).norm() / b[k].P.norm());
  }
  return static_cast<double>(worst);
}

}  // namespace

TEST_CASE("smoothed estimates are those of Rauch, Tung and Striebel") {
  int outliers = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    Case test(chain(random), seed);
    drive(test, 120);
    outliers += test.log->left_out + test.log->outcomes[static_cast<int>(Outcome::gated)];
    const auto oracle = rts(*test.log, test.places);
    INFO(seed);
    CHECK(difference(test.smoothed(), oracle) < 1e-10);
  }
  CHECK(outliers > 100);  // rows and samples were left out
}

TEST_CASE("smoothed estimates are those of one least squares over all states") {
  // Every state moves at random, so that every step has an inverse: information form.
  Case test(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2},
                 "v": {"type": "vector", "size": 1, "unit": "m/s", "init": 0.5, "sigma": 0.3},
                 "d": {"type": "vector", "size": 1, "unit": "m", "sigma": 0.8}},
      "process": {"move": {"type": "integrated", "blocks": {"x": "x", "rate": "v"}},
                  "wander": {"type": "random_walk", "blocks": {"x": "v"}, "q": 0.2},
                  "drift": {"type": "gauss_markov", "blocks": {"x": "d"}, "tau": "20 s", "sigma": 0.8}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [0.7]}}}}})",
            7);
  for (int k = 0; k < 60; ++k) {
    push(test.session, "z", 0.5 * k, {1 + test.normal()});
    test.mark();
  }
  // Unknown: the state after each step, so that an update adds nothing.
  const Log& log = *test.log;
  const int n = log.n;
  std::vector<int> state_of(log.events.size() + 1, 0);
  int states = 1;
  for (std::size_t k = 0; k < log.events.size(); ++k) {
    states += log.events[k].kind == Event::step;
    state_of[k + 1] = states - 1;
  }
  Matrix N = Matrix::Zero(n * states, n * states);
  Vector b = Vector::Zero(n * states);
  const auto add = [&](int column, const Matrix& J, const Vector& y, const Matrix& W) {
    N.block(column, column, J.cols(), J.cols()) += J.transpose() * W * J;
    b.segment(column, J.cols()) += J.transpose() * W * y;
  };
  add(0, Matrix::Identity(n, n), log.x_first, log.P_first.inverse());
  for (std::size_t k = 0; k < log.events.size(); ++k) {
    const Event& event = log.events[k];
    const int column = n * state_of[k];
    if (event.kind == Event::step) {
      Matrix J(n, 2 * n);
      J << -event.Phi, Matrix::Identity(n, n);
      add(column, J, event.x1 - event.Phi * event.x0, event.Q.inverse());
    } else {
      add(column, event.H, event.r + event.H * event.x0, event.R.inverse());
    }
  }
  const Matrix covariance = N.inverse();
  const Vector solution = covariance * b;
  std::vector<Smoothed> batch;
  for (const std::size_t place : test.places)
    batch.push_back({place, solution.segment(n * state_of[place], n),
                     covariance.block(n * state_of[place], n * state_of[place], n, n)});
  CHECK(difference(test.smoothed(), batch) < 1e-10);
}

namespace {

/// λ by the definition, and as a linear function of all that is random.
struct DenseCoStates {
  std::vector<Matrix> lambdas;
  std::vector<Vector> values;
};

DenseCoStates dense_co_states(const Log& log, const std::vector<Matrix>& residual, Eigen::Index size) {
  const int n = log.n;
  Matrix lambda = Matrix::Zero(n, size);
  Vector value = Vector::Zero(n);
  std::vector<Matrix> lambdas(log.events.size() + 1, lambda);
  std::vector<Vector> values(log.events.size() + 1, value);
  for (std::size_t k = log.events.size(); k-- > 0;) {
    const Event& event = log.events[k];
    if (event.kind == Event::step) {
      lambda = (event.Phi.transpose() * lambda).eval();
      value = (event.Phi.transpose() * value).eval();
    } else {
      const Matrix A = Matrix::Identity(n, n) - event.K * event.H, S = event.S.inverse();
      lambda = (event.H.transpose() * S * residual[k] + A.transpose() * lambda).eval();
      value = (event.H.transpose() * S * event.r + A.transpose() * value).eval();
    }
    lambdas[k] = lambda, values[k] = value;
  }
  return {std::move(lambdas), std::move(values)};
}

}  // namespace

TEST_CASE("where components are considered, the covariance is that of the gains that were used") {
  for (int seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    Case test(chain(random, R"(, "consider": ["x0"])"), seed);
    drive(test, 40);
    const Log& log = *test.log;
    const int n = log.n;

    // Every error as a linear function of what is random: the first error, and the noise of each step and update.
    Eigen::Index size = n;
    for (const Event& event : log.events) size += event.kind == Event::step ? n : event.H.rows();
    Matrix covariance = Matrix::Zero(size, size);
    covariance.topLeftCorner(n, n) = log.P_first;
    std::vector<Matrix> error = {Matrix::Identity(n, size)}, residual;
    Eigen::Index at = n;
    for (const Event& event : log.events) {
      const Matrix& before = error.back();
      residual.emplace_back();
      if (event.kind == Event::step) {
        Matrix after = event.Phi * before;
        after.middleCols(at, n) += Matrix::Identity(n, n);
        covariance.block(at, at, n, n) = event.Q;
        at += n;
        error.push_back(after);
      } else {
        const Eigen::Index m = event.H.rows();
        residual.back() = event.H * before;
        residual.back().middleCols(at, m) += Matrix::Identity(m, m);
        covariance.block(at, at, m, m) = event.R;
        at += m;
        error.push_back(before - event.K * residual.back());
      }
    }
    const auto [lambdas, values] = dense_co_states(log, residual, size);
    Matrix M = Matrix::Identity(n, n);
    M(4, 4) = 0;  // x, v, then the first of the drift
    std::vector<Smoothed> oracle;
    for (const std::size_t place : test.places) {
      const bool is_last = place == log.events.size();
      const Matrix P = is_last ? log.events.back().P1 : log.events[place].P0;
      const Vector x = is_last ? log.events.back().x1 : log.events[place].x0;
      const Matrix left = error[place] - M * P * lambdas[place];
      oracle.push_back({place, x + M * P * values[place], left * covariance * left.transpose()});
    }
    INFO(seed);
    CHECK(difference(test.smoothed(), oracle) < 1e-9);
  }
}
