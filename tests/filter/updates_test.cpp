// SPDX-License-Identifier: Apache-2.0
// Ways to update: iterated and unscented against the Kalman filter where all is linear, against independent solutions where
// nothing is, and with plugins that refuse, vanish or throw on the way.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace updates_test {

using namespace binnacle;

namespace {

using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

Session session_of(const std::string& text) { return Session(filter_tests::composition_of(text, CURVED_PLUGIN)); }

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string listed(const Eigen::MatrixXd& A) {
  std::string text = "[";
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    text += i > 0 ? ", [" : "[";
    for (Eigen::Index j = 0; j < A.cols(); ++j) text += (j > 0 ? ", " : "") + number(A(i, j));
    text += "]";
  }
  return text + "]";
}

/// What one update did.
struct Update {
  Outcome outcome = Outcome::rejected;
  Eigen::MatrixXd P0, P1, H, R, K, S, update_S, reset;
  Eigen::VectorXd x0, x1, residual, update_residual, delta;
  double nis = 0;
  int rows = 0;
};

class Recorder final : public StepObserver {
 public:
  explicit Recorder(const Session& session) : info_(session.composition().filters()[0]) {}
  Wants wants() const override { return Wants::everything; }
  void offered(const UpdateRecord& record) override {
    Update update;
    update.outcome = record.outcome;
    update.nis = record.nis;
    update.rows = record.rows;
    const auto vector = [](const double* from, int count) {
      return Eigen::VectorXd(ConstVectorView(from, count).as());
    };
    if (record.residual) {
      update.residual = vector(record.residual, record.rows);
      update.update_residual = vector(record.update_residual, record.rows);
      update.H = record.H.as(), update.R = record.R.as(), update.S = record.S.as();
      update.update_S = record.update_S.as();
    }
    if (record.outcome == Outcome::accepted) {
      update.P0 = record.P0.as(), update.P1 = record.P1.as(), update.K = record.K.as();
      update.x0 = vector(record.x0, info_.stored_size), update.x1 = vector(record.x1, info_.stored_size);
      update.delta = vector(record.delta, info_.dof);
      update.reset = Eigen::MatrixXd::Identity(info_.dof, info_.dof);
      if (record.reset) update.reset = record.reset.as();
    }
    all.push_back(std::move(update));
  }
  std::vector<Update> all;

 private:
  const FilterInfo& info_;
};

struct Run {
  std::vector<Update> updates;
  MeasurementCounts counts;
  std::size_t notes = 0;
};

// ---- linear

/// Blocks of any kind of use, some known exactly, one seen through a derived block, in a stack with correlated noise.
std::string linear_config(std::mt19937& random, const std::string& update) {
  std::normal_distribution<double> normal;
  const auto matrix = [&](int rows, int columns) {
    Eigen::MatrixXd A(rows, columns);
    for (double& a : A.reshaped()) a = normal(random);
    return A;
  };
  const auto noise = [&] {
    const Eigen::MatrixXd A = matrix(2, 2);
    return listed(A * A.transpose() + 0.1 * Eigen::Matrix2d::Identity());
  };
  const auto sigma = [&] { return number(0.5 + std::abs(normal(random))); };
  const std::string see = R"("type": "curved_linear", "R": )" + noise() + R"(, "H": )";
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}},
                "w": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {
        "a": {"type": "vector", "size": 3, "unit": "m", "init": [1, -2, 0.5], "sigma": [)" +
         sigma() + ", 0, " + sigma() + R"(]},
        "b": {"type": "vector", "size": 2, "unit": "m", "sigma": )" +
         sigma() + R"(, "consider": ["x1"]},
        "c": {"type": "vector", "size": 3, "unit": "m", "init": [0.1, 0.2, 0.3], "sigma": )" +
         sigma() + R"(, "estimate": ["x", "z"]},
        "d": {"type": "vector", "size": 2, "unit": "m/s", "sigma": )" +
         sigma() + R"(}},
      "derived": {"mix": {"type": "curved_mix", "blocks": {"x": "c"}, "A": )" +
         listed(matrix(2, 3)) + R"(}},
      "process": {
        "a": {"type": "random_walk", "blocks": {"x": "a"}, "q": [0.1, 0, 0]},
        "b": {"type": "integrated", "blocks": {"x": "b", "rate": "d"}},
        "d": {"type": "gauss_markov", "blocks": {"x": "d"}, "tau": 5, "sigma": 0.3},
        "c": {"type": "random_constant", "blocks": {"x": "c"}}},
      "measurements": {
        "stack": {"channel": "z", "update": )" +
         update + R"(, "stack": {
           "first": {)" +
         see + listed(matrix(2, 3)) + R"(, "blocks": {"x": "a", "y": "mix"}},
           "second": {)" +
         see + listed(matrix(2, 2)) + R"(, "blocks": {"x": "b"}}}},
        "alone": {)" +
         see + listed(matrix(2, 3)) + R"(, "channel": "w", "blocks": {"x": "a", "y": "mix"}, "update": )" + update +
         R"(}}}}})";
}

Run linear_run(unsigned seed, const std::string& update) {
  std::mt19937 random(seed);
  Session session = session_of(linear_config(random, update));
  Recorder recorder(session);
  session.attach(FilterId{0}, &recorder);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 12; ++i) {
    const double z[] = {normal(random), normal(random)};
    session.push(session.channel(i % 3 == 2 ? "w" : "z"), no_time, nanoseconds(0.7 * i), z);
  }
  REQUIRE(session.healthy(FilterId{0}));
  return {std::move(recorder.all), session.counts({{0}, 0}), session.notes(FilterId{0}).items().size()};
}

/// |a − b| by what of P is in the same place.
double distance(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  double worst = 0;
  for (Eigen::Index j = 0; j < a.cols(); ++j)
    for (Eigen::Index i = 0; i < a.rows(); ++i)
      if (const double difference = std::abs(a(i, j) - b(i, j)); difference > 0)
        worst = std::max(worst, difference / std::sqrt(std::max(a(i, i) * a(j, j), 1e-300)));
  return worst;
}

// ---- a pose that sees beacons

constexpr double beacons[3][2] = {{30, 5}, {-10, 40}, {-20, -35}};

struct Scene {
  double heading_sigma = 0.5, position_sigma = 8, range_sigma = 0.5, correlation = 0;
  double z[3] = {37, 33, 47};
  std::string more = {};  // of the measurement
  std::string of_pose = {};
  std::string filter = {};
};

std::string scene_config(const Scene& scene, const std::string& update) {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}, "z2": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {
        "pose": {"type": "curved_pose", "init": {"north": 1, "east": -2, "heading": 0.3}, "sigma": [)" +
         number(scene.position_sigma) + ", " + number(scene.position_sigma) + ", " + number(scene.heading_sigma) + "]" +
         scene.of_pose + R"(},
        "offset": {"type": "vector", "size": 1, "unit": "m", "init": 0.2, "sigma": 1}},
      "derived": {"tip": {"type": "curved_tip", "blocks": {"pose": "pose"}, "lever_arm": [6, 3]}},
      "process": {"keep": {"type": "random_constant", "blocks": {"x": "pose"}},
                  "hold": {"type": "random_constant", "blocks": {"x": "offset"}}},
      "measurements": {"see": {"type": "curved_ranges", "channel": "z", "blocks": {"tip": "tip", "offset": "offset"},
        "beacons": [[30, 5], [-10, 40], [-20, -35]], "sigma": )" +
         number(scene.range_sigma) + R"(, "correlation": )" + number(scene.correlation) + scene.more +
         R"(, "update": )" + update + "}}" + scene.filter + "}}}";
}

Run scene_run(const Scene& scene, const std::string& update, int samples = 1) {
  Session session = session_of(scene_config(scene, update));
  Recorder recorder(session);
  session.attach(FilterId{0}, &recorder);
  for (int i = 0; i < samples; ++i) session.push(session.channel("z"), no_time, i, scene.z);
  return {std::move(recorder.all), session.counts({{0}, 0}), session.notes(FilterId{0}).items().size()};
}

// The same, written down once more.

struct State {
  Real n, e, heading, offset;
};

State plus(const State& x, const Vector& d) {
  const Real phi = d[2], s = phi == 0 ? 1 : std::sin(phi) / phi, c = phi == 0 ? 0 : (1 - std::cos(phi)) / phi;
  const Real a = s * d[0] - c * d[1], b = c * d[0] + s * d[1];
  return {x.n + std::cos(x.heading) * a - std::sin(x.heading) * b,
          x.e + std::sin(x.heading) * a + std::cos(x.heading) * b, x.heading + phi, x.offset + d[3]};
}

Vector minus(const State& y, const State& x) {
  const Real phi = y.heading - x.heading, s = phi == 0 ? 1 : std::sin(phi) / phi,
             c = phi == 0 ? 0 : (1 - std::cos(phi)) / phi;
  Eigen::Matrix<Real, 2, 2> V, C;
  V << s, -c, c, s;
  C << std::cos(x.heading), -std::sin(x.heading), std::sin(x.heading), std::cos(x.heading);
  const Eigen::Matrix<Real, 2, 1> moved = V.inverse() * C.transpose() * Eigen::Matrix<Real, 2, 1>(y.n - x.n, y.e - x.e);
  Vector d(4);
  d << moved[0], moved[1], phi, y.offset - x.offset;
  return d;
}

Vector residual(const Scene& scene, const State& x) {
  const Real n = x.n + std::cos(x.heading) * 6 - std::sin(x.heading) * 3;
  const Real e = x.e + std::sin(x.heading) * 6 + std::cos(x.heading) * 3;
  Vector r(3);
  for (int i = 0; i < 3; ++i) r[i] = scene.z[i] - std::hypot(beacons[i][0] - n, beacons[i][1] - e) - x.offset;
  return r;
}

template <class F>
Matrix differences(F&& f, const Vector& at) {
  constexpr Real step = 1e-5L;
  Matrix J;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    Vector above = at, below = at;
    above[i] += step, below[i] -= step;
    const Vector column = (f(above) - f(below)) / (2 * step);
    J.conservativeResize(column.size(), at.size());
    J.col(i) = column;
  }
  return J;
}

const State prior{1, -2, 0.3L, 0.2L};

Matrix noise_of(const Scene& scene) {
  Matrix R = Matrix::Constant(3, 3, Real(scene.correlation));
  R.diagonal().setOnes();
  return Real(scene.range_sigma) * Real(scene.range_sigma) * R;
}

/// The minimum of δᵀ P⁻¹ δ + rᵀ R⁻¹ r, and the covariance there, by differences along δ alone: no reset Jacobian in it.
struct Likeliest {
  Vector delta;
  Matrix P;
  State x;
};
Likeliest likeliest(const Scene& scene, const Matrix& P, const std::vector<int>& rows = {0, 1, 2}) {
  const Matrix R = noise_of(scene)(rows, rows), weight = R.inverse(), of_prior = P.inverse();
  const auto seen = [&](const Vector& d) { return Vector(residual(scene, plus(prior, d))(rows)); };
  Vector delta = Vector::Zero(P.rows());
  const auto cost = [&](const Vector& d) { return Real(d.dot(of_prior * d) + seen(d).dot(weight * seen(d))); };
  for (int i = 0; i < 300; ++i) {
    const Matrix J = differences(seen, delta);
    const Matrix A = of_prior + J.transpose() * weight * J;
    const Vector step = A.ldlt().solve(-(of_prior * delta + J.transpose() * weight * seen(delta)));
    Real share = 1;
    while (share > 1e-6L && cost(delta + share * step) > cost(delta)) share /= 2;
    delta += share * step;
  }
  const Matrix J = differences(seen, delta);
  const Matrix A = (of_prior + J.transpose() * weight * J).inverse();
  const State x = plus(prior, delta);
  const Matrix T = differences([&](const Vector& d) { return minus(plus(prior, d), x); }, delta);
  return {delta, T * A * T.transpose(), x};
}

Vector sigmas(const Scene& scene) {
  Vector s(4);
  s << scene.position_sigma, scene.position_sigma, scene.heading_sigma, 1;
  return s;
}

const std::string iterated = R"({"type": "iterated", "max": 500, "tolerance": 1e-10})";

}  // namespace

TEST_CASE("on linear models an iterated and an unscented update are the Kalman filter's", "[updates]") {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    const Run ekf = linear_run(seed, R"("ekf")");
    REQUIRE(ekf.updates.size() == 12);
    for (const char* update : {R"("iterated")", R"({"type": "iterated", "max": 1})", R"("unscented")"}) {
      CAPTURE(update);
      const Run other = linear_run(seed, update);
      REQUIRE(other.updates.size() == 12);
      for (std::size_t i = 0; i < 12; ++i) {
        const Update &a = ekf.updates[i], &b = other.updates[i];
        REQUIRE(a.outcome == Outcome::accepted);
        REQUIRE(b.outcome == Outcome::accepted);
        CHECK((a.x1 - b.x1).cwiseAbs().maxCoeff() < 1e-9);
        CHECK(distance(a.P1, b.P1) < 1e-9);
        CHECK((a.residual - b.residual).norm() < 1e-9);
        CHECK((a.update_residual - b.update_residual).norm() < 1e-9);
        CHECK((a.H - b.H).norm() < 1e-9);
        CHECK((a.K - b.K).norm() < 1e-9);
        CHECK(std::abs(a.nis - b.nis) < 1e-9);
        CHECK((b.delta - b.K * b.update_residual).norm() < 1e-12);
      }
    }
    const Run two = linear_run(seed, R"("iterated")");
    CHECK(two.counts.iterated == two.counts.by_outcome[0]);
    CHECK(two.counts.not_converged == 0);
    CHECK(two.counts.iterations <= 2 * two.counts.iterated);
    CHECK(two.notes == 0);
    CHECK(linear_run(seed, R"("unscented")").counts.linearized == 0);
  }
}

TEST_CASE("an iterated update finds the likeliest state and its covariance", "[updates]") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  double most_off = 0;
  for (int i = 0; i < 40; ++i) {
    CAPTURE(i);
    Scene scene;
    scene.correlation = i % 3 == 0 ? 0.6 : 0;
    scene.range_sigma = i % 2 == 0 ? 0.5 : 0.02;
    // Truth is drawn.
    Vector d(4);
    for (int k = 0; k < 4; ++k) d[k] = sigmas(scene)[k] * Real(normal(random));
    Scene empty;
    for (double& z : empty.z) z = 0;
    const Vector exact = -residual(empty, plus(prior, d));
    for (int k = 0; k < 3; ++k) scene.z[k] = static_cast<double>(exact[k]) + scene.range_sigma * normal(random);
    const Run run = scene_run(scene, iterated), ekf = scene_run(scene, R"("ekf")");
    REQUIRE(run.updates.size() == 1);
    const Update& update = run.updates[0];
    REQUIRE(update.outcome == Outcome::accepted);
    CHECK(run.counts.not_converged == 0);
    const Likeliest sought = likeliest(scene, update.P0.cast<Real>());
    const Vector off = sought.delta - update.delta.cast<Real>();
    // In sigma of what is known afterwards. Convergence is linear: a step may be far shorter than what is left.
    const Real far = std::sqrt(off.dot(sought.P.inverse() * off));
    CHECK(far < 1e-6L);
    CHECK(distance(sought.P.cast<double>(), update.P1) < 1e-5);
    const State x{update.x1[0], update.x1[1], update.x1[2], update.x1[3]};
    CHECK(minus(x, sought.x).norm() < 1e-6L);
    const Vector by_ekf = sought.delta - ekf.updates[0].delta.cast<Real>();
    most_off = std::max(most_off, static_cast<double>(std::sqrt(by_ekf.dot(sought.P.inverse() * by_ekf))));
    // The innovation is that of the first linearization.
    CHECK(update.residual == ekf.updates[0].residual);
    CHECK(update.S == ekf.updates[0].S);
    CHECK(update.nis == ekf.updates[0].nis);
    CHECK((update.delta - update.K * update.update_residual).norm() < 1e-9);
    CHECK((update.update_S - update.H * update.P0 * update.H.transpose() - update.R).norm() < 1e-9 * update.S.norm());
  }
  CHECK(most_off > 3);  // what one linearization misses
}

TEST_CASE("what is frozen or known exactly is not moved by iterations, and what is considered not by the correction",
          "[updates]") {
  Scene scene;
  scene.of_pose = R"(, "estimate": ["north", "heading"])";
  const Update frozen = scene_run(scene, iterated).updates[0];
  Scene known;
  known.of_pose = "";
  REQUIRE(frozen.outcome == Outcome::accepted);
  // The east axis of the body is frozen: δ has none of it, but ⊞ turns the way.
  const State x{frozen.x1[0], frozen.x1[1], frozen.x1[2], frozen.x1[3]};
  CHECK(std::abs(minus(x, prior)[1]) < 1e-12L);

  scene.of_pose = R"(, "consider": ["heading"])";
  const Update considered = scene_run(scene, iterated).updates[0];
  CHECK(considered.x1[2] == 0.3);
  CHECK(considered.delta[2] == 0);
  CHECK(std::abs(considered.P1(2, 2) - considered.P0(2, 2)) < 1e-12);
  CHECK(considered.update_residual != considered.residual);
}

TEST_CASE("an update that is iterated too little says so, and has come down all the same", "[updates]") {
  Scene scene;
  scene.range_sigma = 0.01;
  scene.z[0] = 20, scene.z[1] = 45, scene.z[2] = 60;
  const auto cost = [&](const Update& update) {
    const Vector d = update.delta.cast<Real>(), r = residual(scene, plus(prior, d));
    return static_cast<double>(
        Real(d.dot(update.P0.cast<Real>().inverse() * d) + r.dot(noise_of(scene).inverse() * r)));
  };
  const std::string to = R"({"type": "iterated", "tolerance": 1e-4, "max": )";
  const Run whole = scene_run(scene, to + "500}");
  REQUIRE(whole.counts.not_converged == 0);
  REQUIRE(whole.counts.iterations > 3);
  CHECK(whole.counts.iterated == 1);
  double last = 1e300;
  for (int most = 1; most < static_cast<int>(whole.counts.iterations); ++most) {
    CAPTURE(most);
    const Run run = scene_run(scene, to + std::to_string(most) + "}");
    CHECK(run.counts.not_converged == 1);
    CHECK(run.counts.iterations == most);
    CHECK(run.notes == 2);  // the model's own, and that it did not converge
    CHECK(cost(run.updates[0]) < last);
    last = cost(run.updates[0]);
  }
  CHECK(cost(whole.updates[0]) <= last);
}

TEST_CASE("a row or a sample that is refused on the way ends the iteration at what was good", "[updates]") {
  Scene scene;
  scene.range_sigma = 0.01;
  scene.z[0] = 20, scene.z[1] = 45, scene.z[2] = 60;
  const Update ekf = scene_run(scene, R"("ekf")").updates[0];
  for (const char* limit : {"vanishes_beyond", "refuses_beyond"}) {
    CAPTURE(limit);
    // At the estimate the ranges are 33, 33 and 46 m; the likeliest state has 60.
    scene.more = R"(, ")" + std::string(limit) + R"(": 52)";
    const Run run = scene_run(scene, iterated);
    REQUIRE(run.updates[0].outcome == Outcome::accepted);
    CHECK(run.counts.not_converged == 1);
    CHECK(run.updates[0].rows == 3);
    CHECK(run.updates[0].delta.allFinite());
    CHECK(run.notes == 2);
    // Where the first step finds nothing, it is made as it is.
    scene.more = R"(, ")" + std::string(limit) + R"(": 46.6)";
    const Run stuck = scene_run(scene, iterated);
    CHECK(stuck.counts.not_converged == 1);
  }
}

TEST_CASE("rows that a gate took out stay out while the others are iterated", "[updates]") {
  Scene scene;
  scene.position_sigma = 3;
  scene.z[0] = 36, scene.z[1] = 300, scene.z[2] = 44;
  scene.more = R"(, "gate": {"probability": 0.999, "by": "row"})";
  const Run run = scene_run(scene, iterated);
  REQUIRE(run.updates[0].outcome == Outcome::accepted);
  CHECK(run.counts.rows_left_out == 1);
  CHECK(run.updates[0].rows == 2);
  CHECK(run.counts.not_converged == 0);
  const Likeliest sought = likeliest(scene, run.updates[0].P0.cast<Real>(), {0, 2});
  CHECK((sought.delta - run.updates[0].delta.cast<Real>()).norm() < 1e-6L);
}

TEST_CASE("an unscented update is the regression on the sigma points", "[updates]") {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  double most_off = 0;
  for (int i = 0; i < 20; ++i) {
    CAPTURE(i);
    Scene scene;
    scene.heading_sigma = 1;
    scene.correlation = i % 2 == 0 ? 0.5 : 0;
    for (double& z : scene.z) z += 5 * normal(random);
    const Run run = scene_run(scene, R"("unscented")", 2);
    REQUIRE(run.updates.size() == 2);
    CHECK(run.counts.linearized == 0);
    const Update& update = run.updates[0];
    // Four components of which all are seen: no weight in the centre, spread 2.
    const Matrix P = update.P0.cast<Real>(), L = P.llt().matrixL();
    Matrix all(3, 8);
    for (int k = 0; k < 8; ++k) all.col(k) = residual(scene, plus(prior, (k % 2 == 0 ? 2 : -2) * L.col(k / 2)));
    const Vector mean = all.rowwise().mean();
    const Matrix centred = all.colwise() - mean;
    Matrix with_state = Matrix::Zero(4, 3);
    for (int k = 0; k < 8; ++k) with_state += (k % 2 == 0 ? 2 : -2) * L.col(k / 2) * centred.col(k).transpose() / 8;
    const Matrix S = centred * centred.transpose() / 8 + noise_of(scene);
    const Matrix K = -with_state * S.inverse();  // r falls where h grows
    CHECK((update.residual.cast<Real>() - mean).norm() < 1e-10L);
    CHECK((update.S.cast<Real>() - S).norm() < 1e-10L * S.norm());
    CHECK((update.K.cast<Real>() - K).norm() < 1e-10L * K.norm());
    CHECK((update.delta.cast<Real>() - K * mean).norm() < 1e-9L);
    const Matrix T = update.reset.cast<Real>();
    const Matrix P1 = T * (P - K * S * K.transpose()) * T.transpose();
    CHECK(distance(P1.cast<double>(), update.P1) < 1e-9);
    CHECK(std::abs(update.nis - static_cast<double>(mean.dot(S.inverse() * mean))) < 1e-8 * update.nis);
    const Update ekf = scene_run(scene, R"("ekf")").updates[0];
    most_off = std::max(most_off, (ekf.S - update.S).norm() / ekf.S.norm());
  }
  CHECK(most_off > 0.05);
}

TEST_CASE("an unscented update that one sigma point refuses, or sees otherwise, is linearized, and that is counted",
          "[updates]") {
  for (const char* limit : {"vanishes_beyond", "refuses_beyond"}) {
    CAPTURE(limit);
    Scene scene;
    scene.more = R"(, ")" + std::string(limit) + R"(": 52)";
    const Run run = scene_run(scene, R"("unscented")"), ekf = scene_run(scene, R"("ekf")");
    CHECK(run.counts.linearized == 1);
    CHECK(run.notes == 2);
    CHECK(run.updates[0].residual == ekf.updates[0].residual);
    CHECK(run.updates[0].x1 == ekf.updates[0].x1);
    CHECK(run.updates[0].P1 == ekf.updates[0].P1);
  }
}

TEST_CASE("models keep notes and memory of one call alone, however often they are asked", "[updates]") {
  // The model counts its calls in memory, and leaves a note in each: the snapshots of all updates of a linear filter would
  // differ else. Here: the first call's memory is kept.
  for (const char* update : {R"("ekf")", R"("iterated")", R"("unscented")"}) {
    CAPTURE(update);
    Scene scene;
    scene.position_sigma = 1, scene.heading_sigma = 0.05;
    Session session = session_of(scene_config(scene, update));
    for (int i = 0; i < 5; ++i) session.push(session.channel("z"), no_time, i, scene.z);
    bool is_found = false;
    const Diagnostics notes = session.notes(FilterId{0});
    for (const auto& item : notes.items())
      if (item.message.find("a note of each call") != std::string::npos) {
        is_found = true;
        CHECK(item.message.find("5") != std::string::npos);
      }
    CHECK(is_found);
  }
}

TEST_CASE("an exact measurement is iterated with whole steps", "[updates]") {
  Scene scene;
  scene.range_sigma = 0.5;
  scene.correlation = 1;  // two differences of ranges are exact
  scene.z[0] = 37, scene.z[1] = 36, scene.z[2] = 45;
  const Run run = scene_run(scene, iterated);
  REQUIRE(run.updates[0].outcome == Outcome::accepted);
  CHECK(run.counts.not_converged == 0);
  const Vector d = run.updates[0].delta.cast<Real>(), r = residual(scene, plus(prior, d));
  CHECK(std::abs(r[0] - r[1]) < 1e-6L);
  CHECK(std::abs(r[0] - r[2]) < 1e-6L);
}

TEST_CASE("what is wrong with an update is said at its place", "[updates]") {
  const auto message = [](const std::string& update) -> std::string {
    try {
      session_of(scene_config({}, update));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  const auto has = [&](const std::string& update, const std::string& text) {
    CAPTURE(update, message(update));
    CHECK(message(update).find(text) != std::string::npos);
  };
  has(R"("unscentd")", "/filters/f/measurements/see/update: an update is ekf, iterated or unscented; found 'unscentd'");
  has(R"("unscentd")", "did you mean 'unscented'?");
  has(R"({"max": 3})", "missing key 'type' of 'update'");
  has(R"({"type": "iterated", "maximum": 3})", "unknown key of the update 'iterated'");
  has(R"({"type": "unscented", "max": 3})", "unknown key of the update 'unscented'");
  has(R"({"type": "iterated", "max": 0})", "/update/max");
  has(R"({"type": "iterated", "tolerance": -1})", "/update/tolerance");
  has("3", "/filters/f/measurements/see/update");
  CHECK(message(R"({"type": "ekf"})").empty());
  CHECK(message(R"({"type": "iterated", "max": 3, "tolerance": "1e-2"})").empty());
  const auto composition =
      filter_tests::composition_of(scene_config({}, R"({"type": "iterated", "max": 3, "tolerance": 0.01})"),
                                   CURVED_PLUGIN);
  const UpdateInfo& update = composition->filters()[0].measurements[0].update;
  CHECK(update.type == "iterated");
  CHECK(update.max == 3);
  CHECK(update.tolerance == 0.01);
}

}  // namespace updates_test
