// SPDX-License-Identifier: Apache-2.0
// Smoothed estimates of composed linear filters against three oracles in long double: Rauch, Tung and Striebel; one dense
// least squares over all states; and, where gains are not optimal, the joint error through the gains that were used.
#include <algorithm>
#include <cmath>
#include <map>
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

namespace smoother_test {

using namespace binnacle;
using filter_tests::composition_of;
using filter_tests::push;
using filter_tests::with_form;

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
  void inflated(const InflationRecord& record) override {
    next_.inflated(record);
    if (record.scales) {
      breaks.push_back(events.size());
    } else {
      Event event;
      event.Phi = Matrix::Identity(n, n), event.Q = wide(record.variances, n).asDiagonal();
      event.x0 = event.x1 = events.empty() ? x_first : events.back().x1;
      event.P0 = wide(record.P0), event.P1 = wide(record.P1);
      events.push_back(std::move(event));
      ++inflations;
    }
  }

  int n = 0;
  Vector x_first;
  Matrix P_first;
  std::vector<Event> events;
  std::vector<std::size_t> breaks;  // events before P was scaled
  std::map<int, int> outcomes;
  int left_out = 0;
  int inflations = 0;

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
std::string chain(std::mt19937& random, const std::string& extra = "", const std::string& update = "ekf") {
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
        "both": {"channel": "z", "update": ")" +
         update + R"(", "gate": {"probability": 0.99, "by": ")" + std::string(by_row ? "row" : "sample") +
         R"("}, "recover": false, "stack": {
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

TEST_CASE("smoothed estimates are those of Rauch, Tung and Striebel, in each form of P") {
  const std::string form = GENERATE("joseph", "ud", "square_root");
  CAPTURE(form);
  int outliers = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    Case test(with_form(chain(random), form), seed);
    drive(test, 120);
    outliers += test.log->left_out + test.log->outcomes[static_cast<int>(Outcome::gated)];
    const auto oracle = rts(*test.log, test.places);
    INFO(seed);
    CHECK(difference(test.smoothed(), oracle) < 1e-10);
  }
  CHECK(outliers > 100);  // rows and samples were left out
}

// Two rows see the same position, of which the prior knows nothing: S is singular in doubles, and its factor is not.
TEST_CASE("what a filter with a factor of P has used, but the smoother can not, makes no number") {
  for (const char* sigma : {"1", "1e10"}) {
    Case test(with_form(R"({"binnacle": 1,
      "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}},
                  "y": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
      "filters": {"f": {
        "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "sigma": )" +
                            std::string(sigma) + R"(}},
        "process": {"wander": {"type": "random_walk", "blocks": {"x": "x"}, "q": 0.2}},
        "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"},
                                 "H": [[1], [1]], "sigma": [1, 1]},
                         "vague": {"type": "linear_measurement", "channel": "y", "blocks": {"x": "x"},
                                   "sigma": [1e12]}}}}})",
                        "ud"),
              3);
    push(test.session, "y", 0, {0});
    test.mark();
    for (const double t : {1.0, 2.0}) {
      push(test.session, "z", t, {0.5, -0.5});
      test.mark();
    }
    CHECK(test.log->outcomes[static_cast<int>(Outcome::accepted)] == 3);
    CHECK(test.log->events.back().P1(0, 0) < 1);
    const auto smoothed = test.smoothed();
    CHECK(std::isfinite(static_cast<double>(smoothed.back().P(0, 0))));
    CHECK(std::isfinite(static_cast<double>(smoothed.front().P(0, 0))) == (std::string(sigma) == "1"));
    CHECK(std::isfinite(static_cast<double>(smoothed.front().x[0])) == (std::string(sigma) == "1"));
  }
}

TEST_CASE("where all is linear, what is smoothed after other updates is what is smoothed after the Kalman filter's") {
  for (int seed = 1; seed <= 5; ++seed) {
    std::vector<std::vector<Smoothed>> all;
    for (const char* update : {"ekf", "iterated", "unscented"}) {
      std::mt19937 random(static_cast<unsigned>(seed));
      Case test(chain(random, "", update), seed);
      drive(test, 120);
      all.push_back(test.smoothed());
    }
    INFO(seed);
    CHECK(difference(all[1], all[0]) < 1e-9);
    CHECK(difference(all[2], all[0]) < 1e-9);
  }
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

namespace {

/// Position by fixes with a gate and velocity by a speedometer without one; `recover` of the fixes.
std::string with_recovery(const std::string& recover) {
  return filter_tests::fix_and_speed(R"("sigma": [0.5], "gate": 0.999, "recover": )" + recover, R"("sigma": [0.3])");
}

/// The truth jumps by 200 m at 20 s.
void drive_with_jump(Case& test) {
  for (int k = 0; k < 80; ++k) {
    const double t = 0.5 * k;
    push(test.session, "v", t, {0.3 * test.normal()});
    push(test.session, "z", t, {(t < 20 ? 0 : 200) + 0.5 * test.normal()});
    test.mark();
  }
}

}  // namespace

TEST_CASE("variances that are added to P are process noise") {
  // P − P Λ P leaves the digits that the smaller of the two has: P of (1000 m)², smoothed to (0.16 m)², loses seven.
  for (const auto& [sigma, tolerance] : {std::pair("10", 1e-10), std::pair("1000", 1e-7)}) {
    Case test(with_recovery(R"({"after": 5, "inflate": {"position": )" + std::string(sigma) + "}}"), 11);
    drive_with_jump(test);
    REQUIRE(test.log->outcomes[static_cast<int>(Outcome::gated)] > 0);
    REQUIRE(test.log->breaks.empty());
    REQUIRE(test.log->inflations > 0);
    const auto oracle = rts(*test.log, test.places);
    INFO(sigma);
    CHECK(difference(test.smoothed(), oracle) < tolerance);
    CHECK(test.filter->breaks() == 0);
  }
}

TEST_CASE("where recovery scaled P, what came later says nothing about what was before") {
  Case test(with_recovery("{}"), 12);
  drive_with_jump(test);
  REQUIRE(test.log->breaks.size() >= 1);
  const std::size_t first = test.log->breaks.front(), last = test.log->breaks.back();
  const auto smoothed = test.smoothed();
  CHECK(test.filter->breaks() >= 1);
  // Before: as if the data ended there. The oracle's log ends with the event before the break.
  Case half(with_recovery("{}"), 12);
  drive_with_jump(half);
  half.log->events.resize(first);
  std::vector<std::size_t> before, after;
  for (const std::size_t place : test.places) {
    if (place <= first) before.push_back(place);
    if (place > last) after.push_back(place);
  }
  REQUIRE(before.size() > 20);
  REQUIRE(after.size() > 20);
  const std::vector<Smoothed> head(smoothed.begin(), smoothed.begin() + static_cast<std::ptrdiff_t>(before.size()));
  const std::vector<Smoothed> tail(smoothed.end() - static_cast<std::ptrdiff_t>(after.size()), smoothed.end());
  CHECK(difference(head, rts(*half.log, before)) < 1e-10);
  CHECK(difference(tail, rts(*test.log, after)) < 1e-10);
}

TEST_CASE("a reset Jacobian is one more transition") {
  std::mt19937 random(5);
  const auto filled = [&](int rows, int columns) {
    Eigen::MatrixXd A(rows, columns);
    for (double& value : A.reshaped()) value = std::normal_distribution<double>()(random);
    return A;
  };
  const auto view = [](const Eigen::MatrixXd& A) {
    return ConstMatrixView{A.data(), static_cast<int>(A.rows()), static_cast<int>(A.cols()),
                           static_cast<int>(A.rows())};
  };
  constexpr int n = 4, m = 2;
  // All elements of Φ.
  const Case test(R"({"binnacle": 1, "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {"blocks": {"x": {"type": "vector", "size": 4, "unit": "m", "sigma": 1}},
      "process": {"stay": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "H": [[1, 0, 0, 0]],
                               "sigma": [1]}}}}})",
                  1);
  FilterInfo info = test.session.composition().filters()[0];
  info.transition = {{0, 0, Structure::dense}};
  const smooth::TransitionPattern pattern(info);
  for (const bool considers : {false, true}) {
    std::vector<unsigned char> considered;
    if (considers) considered = {0, 0, 0, 1};
    smooth::CoStates in_one(pattern, considered, m), in_two(pattern, considered, m);
    for (int k = 0; k < 5; ++k) {
      const Eigen::MatrixXd Phi = filled(n, n), T = Eigen::MatrixXd::Identity(n, n) + 0.1 * filled(n, n);
      const Eigen::MatrixXd H = filled(m, n), K = filled(n, m), R = Eigen::MatrixXd::Identity(m, m),
                            half = filled(m, m), S = R + half * half.transpose(), none = Eigen::MatrixXd::Zero(n, n);
      const Eigen::VectorXd r = filled(m, 1);
      std::vector<double> phi(pattern.size()), reset(pattern.size());
      pattern.gather(view(Phi), phi.data());
      pattern.gather(view(T), reset.data());
      smooth::UpdateTerms terms{view(H), view(K), view(S), view(R), r.data(), {}};
      in_two.step(reset.data(), view(none));
      in_two.update(terms);
      terms.reset = view(T);
      in_one.update(terms);
      for (auto* co_states : {&in_one, &in_two}) co_states->step(phi.data(), view(none));
    }
    CHECK((in_one.lambda() - in_two.lambda()).norm() < 1e-10 * in_two.lambda().norm());
    CHECK((in_one.Lambda() - in_two.Lambda()).norm() < 1e-10 * in_two.Lambda().norm());
  }
}

TEST_CASE("the smoothed errors of 200 runs with a considered component are as large as their covariance says") {
  const std::string config = R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "sigma": 2},
                 "v": {"type": "vector", "size": 1, "unit": "m/s", "sigma": 0.5},
                 "d": {"type": "vector", "size": 1, "unit": "m", "sigma": 1.5, "consider": ["x"]}},
      "process": {"move": {"type": "integrated", "blocks": {"x": "x", "rate": "v"}},
                  "wander": {"type": "random_walk", "blocks": {"x": "v"}, "q": 0.3},
                  "drift": {"type": "gauss_markov", "blocks": {"x": "d"}, "tau": "6 s", "sigma": 1.5}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x", "bias": "d"},
                               "sigma": [0.4]}}}}})";
  constexpr int runs = 200, instants = 60;
  const auto drive = [](Case& test, const std::vector<double>& z) {
    for (int k = 0; k < instants; ++k) {
      push(test.session, "z", 0.5 * k, {z[static_cast<std::size_t>(k)]});
      test.mark();
    }
  };
  Case model(config, 1);  // Φ, Q, H and R are the same whatever is measured
  drive(model, std::vector<double>(instants, 0.0));
  const Log& log = *model.log;
  const auto noise = [](Case& test, const Matrix& covariance) {
    Vector v(covariance.rows());
    for (auto& value : v) value = test.normal();
    return Vector(Matrix(covariance.llt().matrixL()) * v);
  };
  std::map<std::size_t, double> nees;  // by place, summed
  const std::vector<std::size_t> picked = {0, 20, 40, 55};
  for (int run = 0; run < runs; ++run) {
    Case test(config, 100 + run);
    std::vector<double> z;
    std::vector<Vector> truth = {noise(test, log.P_first)};
    for (const Event& event : log.events) {
      if (event.kind == Event::step) {
        const Matrix Q = event.Q + 1e-18L * Matrix::Identity(3, 3);
        truth.push_back(event.Phi * truth.back() + noise(test, Q));
      } else {
        z.push_back(static_cast<double>((event.H * truth.back() + noise(test, event.R))[0]));
        truth.push_back(truth.back());
      }
    }
    REQUIRE(z.size() == instants);
    drive(test, z);
    const auto smoothed = test.smoothed();
    for (const std::size_t k : picked) {
      const Vector error = truth[test.places[k]] - smoothed[k].x;
      nees[k] += static_cast<double>(error.dot(smoothed[k].P.ldlt().solve(error)));
    }
  }
  const boost::math::chi_squared distribution(3.0 * runs);
  const double out = 0.01 / static_cast<double>(picked.size()) / 2;
  for (const auto& [k, sum] : nees) {
    CAPTURE(k, sum / runs);
    CHECK(sum > boost::math::quantile(distribution, out));
    CHECK(sum < boost::math::quantile(boost::math::complement(distribution, out)));
  }
}

}  // namespace smoother_test
