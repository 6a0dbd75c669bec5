// SPDX-License-Identifier: Apache-2.0
// "propagation": "unscented": the Kalman filter where the models are linear, the unscented filter of the textbook where they
// are not, and what it does where sigma points can not be had.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <boost/math/distributions/chi_squared.hpp>

#include "allocations.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"
#include "skip.hpp"

namespace sigma_propagation_test {

using namespace binnacle;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using filter_tests::composition_of;
using filter_tests::push;

namespace {

const std::string unscented = R"(, "propagation": "unscented")";

Session session_of(const std::string& text) { return Session(composition_of(text, SPIN_PLUGIN)); }

/// The last step's Φ, Qd and P, and P now.
struct Log final : StepObserver {
  Wants wants() const override { return Wants::everything; }
  const double* nominal() override { return path; }
  void started(Time, const double*, ConstMatrixView its_P) override { P = its_P.as(); }
  void stepped(const StepRecord& record) override {
    Phi = record.Phi.as(), Qd = record.Qd.as(), P = record.P1.as(), P0 = record.P0.as();
    worst = std::max(worst, (Phi * record.P0.as() * Phi.transpose() + Qd - P).norm() / (1e-300 + P.norm()));
  }
  void offered(const UpdateRecord& record) override {
    if (record.outcome == Outcome::accepted) P = record.P1.as();
  }
  MatrixXd Phi, Qd, P, P0;
  const double* path = nullptr;
  double worst = 0;
};

VectorXd state_of(const Session& session) {
  const auto x = session.state({0});
  return Eigen::Map<const VectorXd>(x.data(), static_cast<Eigen::Index>(x.size()));
}

// ---- linear filters

/// Random numbers as JSON.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : engine_(seed) {}
  double number() { return std::normal_distribution<double>()(engine_); }
  bool chance(double p) { return std::uniform_real_distribution<double>()(engine_) < p; }
  std::string text(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
  }
  std::string list(int n) {
    std::string all = "[";
    for (int i = 0; i < n; ++i) all += (i > 0 ? ", " : "") + text(number());
    return all + "]";
  }
  /// Some are zero: P is singular.
  std::string sigmas(int n) {
    std::string all = "[";
    for (int i = 0; i < n; ++i) all += (i > 0 ? ", " : "") + text(chance(0.25) ? 0.0 : 0.1 + std::abs(number()));
    return all + "]";
  }
  /// Of a motion that dies away: one that grows by e^12 in the run magnifies rounding by as much, in either filter.
  std::string dynamics(int n) {
    std::string all = "[";
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        all += (j > 0 ? ", " : i > 0 ? "], [" : "[") + text(0.5 * number() - (i == j ? 1.5 : 0));
    return all + "]]";
  }
  std::string block(const std::string& name, int n, const std::string& unit, const std::string& use = "") {
    return "\"" + name + R"(": {"type": "vector", "size": )" + std::to_string(n) + R"(, "unit": ")" + unit +
           R"(", "init": )" + list(n) + R"(, "sigma": )" + sigmas(n) + use + "}";
  }

 private:
  std::mt19937 engine_;
};

/// Positions integrate velocities, one of them through a derived value; a Van Loan group of what has a closed form and what has
/// none; frozen, considered and exactly known components.
std::string linear_filter(unsigned seed, const std::string& propagation) {
  Numbers draw(seed);
  const std::string frozen = draw.chance(0.5) ? R"(, "estimate": ["x", "z"])" : "";
  const std::string held = frozen.empty() || draw.chance(0.5) ? "" : R"(, "hold": true)";
  const std::string considered = draw.chance(0.5) ? R"(, "consider": ["x1"])" : "";
  std::string blocks = draw.block("a", 2, "m") + ", " + draw.block("b", 2, "m/s") + ", ";
  blocks += draw.block("c", 3, "rad", frozen + held) + ", " + draw.block("d", 1, "m") + ", ";
  blocks += draw.block("g", 2, "m", considered) + ", " + draw.block("k", 2, "m") + ", " + draw.block("w", 1, "m");
  const std::string wander = draw.chance(0.5)
                                 ? R"("type": "gauss_markov", "blocks": {"x": "b"}, "tau": 3, "sigma": 0.8)"
                                 : R"("type": "random_walk", "blocks": {"x": "b"}, "q": 0.4)";
  return R"({"binnacle": 1,
    "sources": {"za": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}},
                "zc": {"type": "pushed", "fields": {"z0": {"unit": "rad"}}},
                "zd": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {)" +
         blocks + R"(},
      "derived": {"both": {"type": "mixed", "blocks": {"x": "b"}}},
      "process": {
        "move": {"type": "integrated", "blocks": {"x": "a", "rate": "b"}, "q": 0.1},
        "wander": {)" +
         wander + R"(},
        "swing": {"type": "linear", "blocks": {"x": "c"}, "F": )" +
         draw.dynamics(3) + R"(, "q": [0.3]},
        "away": {"type": "integrated", "blocks": {"x": "d", "rate": "both"}},
        "drift": {"type": "gauss_markov", "blocks": {"x": "g"}, "tau": [1, 5], "sigma": [0.3, 2]},
        "keep": {"type": "random_constant", "blocks": {"x": "k"}},
        "walk": {"type": "random_walk", "blocks": {"x": "w"}, "q": 0.2}},
      "measurements": {
        "za": {"type": "linear_measurement", "channel": "za", "blocks": {"x": "a", "bias": "g"}, "sigma": [0.5, 0.7]},
        "zc": {"type": "linear_measurement", "channel": "zc", "blocks": {"x": "c"}, "H": [[1, -1, 0.5]], "sigma": [0.2]},
        "zd": {"type": "linear_measurement", "channel": "zd", "blocks": {"x": "d", "bias": "w"}, "sigma": [0.3]}})" +
         propagation + "}}}";
}

/// The largest difference of two filters after every sample, in σ and relative to σσ.
struct Difference {
  void add(const Session& a, const Session& b, const Log& log_a, const Log& log_b) {
    const VectorXd xa = state_of(a), xb = state_of(b);
    x = std::max(x, ((xa - xb).array().abs() / (1 + xb.array().abs())).maxCoeff());
    for (int j = 0; j < log_a.P.cols(); ++j)
      for (int i = 0; i < log_a.P.rows(); ++i) {
        const double scale = std::sqrt(log_b.P(i, i) * log_b.P(j, j));
        if (scale > 0) P = std::max(P, std::abs(log_a.P(i, j) - log_b.P(i, j)) / scale);
      }
  }
  double x = 0, P = 0;
};

}  // namespace

TEST_CASE("with linear models, singular P, frozen and considered components it is the Kalman filter") {
  Difference worst;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Session kalman = session_of(linear_filter(seed, "")), points = session_of(linear_filter(seed, unscented));
    Log of_kalman, of_points;
    kalman.attach({0}, &of_kalman);
    points.attach({0}, &of_points);
    std::mt19937 engine(seed + 1000);
    std::normal_distribution<double> normal;
    for (int k = 0; k < 30; ++k) {
      const double t = 0.2 * k;
      const std::vector<double> a = {normal(engine), normal(engine)}, c = {normal(engine)}, d = {normal(engine)};
      for (Session* session : {&kalman, &points}) {
        push(*session, "za", t, a);
        if (k % 2 == 0) push(*session, "zc", t + 0.05, c);
        if (k % 3 == 0) push(*session, "zd", t + 0.1, d);
      }
      REQUIRE(points.healthy({0}));
      worst.add(points, kalman, of_points, of_kalman);
    }
    CHECK((of_points.Phi - of_kalman.Phi).norm() < 1e-6 * of_kalman.Phi.norm());
    CHECK((of_points.Qd - of_kalman.Qd).norm() < 1e-9 * of_kalman.Qd.norm());
    CHECK(of_points.worst < 1e-12);
    INFO(points.notes({0}).text());
    CHECK(points.notes({0}).empty());
  }
  std::printf("unscented propagation of linear filters: worst difference %.2g of 1 + |x|, %.2g of P\n", worst.x,
              worst.P);
  CHECK(worst.x < 1e-9);
  CHECK(worst.P < 1e-9);
}

// ---- an attitude and a bias, written densely in long double

namespace {

using Number = long double;
using Vector3 = Eigen::Matrix<Number, 3, 1>;
using Vector6 = Eigen::Matrix<Number, 6, 1>;
using Matrix3 = Eigen::Matrix<Number, 3, 3>;
using Matrix6 = Eigen::Matrix<Number, 6, 6>;
using Quaternion = Eigen::Quaternion<Number>;

Quaternion turn_by(const Vector3& phi) {
  const Number angle = phi.norm();
  return angle > 0 ? Quaternion(Eigen::AngleAxis<Number>(angle, phi / angle)) : Quaternion::Identity();
}

Vector3 turn_from(const Quaternion& a, const Quaternion& b) {  // a = exp(·) b
  Quaternion q = a * b.conjugate();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Number sine = q.vec().norm();
  return sine > 0 ? Vector3(2 * std::atan2(sine, q.w()) / sine * q.vec()) : Vector3(2 * q.vec());
}

Matrix3 skew(const Vector3& v) {
  Matrix3 S;
  S << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return S;
}

/// How an injected rotation turns what is left of the error: Σ [φ×]^k / (k+1)!.
Matrix3 left_jacobian(const Vector3& phi) {
  Matrix3 sum = Matrix3::Identity(), term = Matrix3::Identity();
  for (int k = 1; k < 30; ++k) {
    term = (term * skew(phi) / (k + 1)).eval();
    sum += term;
  }
  return sum;
}

/// The textbook's unscented filter on SO(3) × R³, all weights alike.
struct Textbook {
  Quaternion q;
  Vector3 b;
  Matrix6 P;
  Matrix6 cross = Matrix6::Zero();  // Σ w e ξᵀ of the last step
  int steps = 0;

  void step(Number dt, const Vector3& rate, Number growth, Number density) {
    const Matrix6 L = Eigen::LLT<Matrix6>(P).matrixL();
    std::vector<Quaternion> turned;
    std::vector<Vector3> biases;
    std::vector<Vector6> offsets;
    for (int i = 0; i < 12; ++i) {
      const Vector6 xi = (i % 2 == 0 ? 1 : -1) * std::sqrt(Number(6)) * L.col(i / 2);
      const Vector3 bias = b + xi.tail<3>();
      turned.push_back(turn_by(xi.head<3>()) * q * turn_by(dt * ((1 + growth * steps) * rate - bias)));
      biases.push_back(bias);
      offsets.push_back(xi);
    }
    q = q * turn_by(dt * ((1 + growth * steps) * rate - b));
    for (int iteration = 0; iteration < 50; ++iteration) {
      Vector3 mean = Vector3::Zero();
      for (const auto& one : turned) mean += turn_from(one, q) / 12;
      q = turn_by(mean) * q;
    }
    P.setZero();
    cross.setZero();
    for (int i = 0; i < 12; ++i) {
      Vector6 e;
      e << turn_from(turned[static_cast<std::size_t>(i)], q), biases[static_cast<std::size_t>(i)] - b;
      P += e * e.transpose() / 12;
      cross += e * offsets[static_cast<std::size_t>(i)].transpose() / 12;
    }
    for (int i = 0; i < 3; ++i) P(i, i) += density * density * dt;
    ++steps;
  }

  void see_bias(const Vector3& z, Number sigma) {
    const Eigen::Matrix<Number, 6, 3> G = P.rightCols<3>();
    const Matrix3 S = P.bottomRightCorner<3, 3>() + sigma * sigma * Matrix3::Identity();
    const Eigen::Matrix<Number, 6, 3> K = G * S.inverse();
    const Vector6 delta = K * (z - b);
    P = (P - K * S * K.transpose()).eval();
    q = turn_by(delta.head<3>()) * q;
    b += delta.tail<3>();
    Matrix6 T = Matrix6::Identity();
    T.topLeftCorner<3, 3>() = left_jacobian(delta.head<3>());
    P = (T * P * T.transpose()).eval();
  }
};

const char* const spinning = R"({"binnacle": 1,
  "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "rad/s"}, "z1": {"unit": "rad/s"}, "z2": {"unit": "rad/s"}}}},
  "filters": {"f": {
    "blocks": {"attitude": {"type": "navigation/attitude", "init": {"roll": 0.1, "pitch": -0.2, "yaw": 1},
                            "sigma": [0.3, 0.2, 0.4]},
               "bias": {"type": "vector", "size": 3, "unit": "rad/s", "sigma": [SIGMA]}},
    "process": {"turn": {"type": "spin", "blocks": {"attitude": "attitude", "bias": "bias"},
                         "rate": [0.3, -0.2, 0.5], "growth": 0.1, "noise": 0.02 MORE},
                "keep": {"type": "random_constant", "blocks": {"x": "bias"}}},
    "measurements": {"z": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "bias"}, "sigma": [0.2]}}
    PROPAGATION}}})";

std::string spinning_with(const std::string& propagation, const std::string& sigma = "0.2, 0.3, 0.1",
                          const std::string& more = "") {
  std::string text = spinning;
  for (const auto& [word, by] :
       {std::pair("SIGMA", sigma), std::pair("MORE", more), std::pair("PROPAGATION", propagation)})
    text.replace(text.find(word), std::string(word).size(), by);
  return text;
}

std::vector<double> seen_at(int k) { return {0.05 * std::sin(k), 0.1 * std::cos(2.0 * k), -0.05 * std::sin(0.7 * k)}; }

}  // namespace

TEST_CASE(
    "an attitude with a bias is that of the textbook's filter, written densely, and a model's memory counts the "
    "centre's calls") {
  Session session = session_of(spinning_with(unscented)), ekf = session_of(spinning_with(""));
  Log log, of_ekf;
  session.attach({0}, &log);
  ekf.attach({0}, &of_ekf);
  Textbook book;
  double distance = 0;
  for (int k = 0; k <= 20; ++k) {
    push(session, "z", 0.5 * k, seen_at(k));
    push(ekf, "z", 0.5 * k, seen_at(k));
    if (k == 0) {
      const VectorXd x = state_of(session);
      const Vector3 roll(0.1L, 0, 0), pitch(0, -0.2L, 0), yaw(0, 0, 1);
      book.q = turn_by(yaw) * turn_by(pitch) * turn_by(roll);
      book.b.setZero();
      Vector6 sigma;
      sigma << 0.3L, 0.2L, 0.4L, 0.2L, 0.3L, 0.1L;
      book.P = sigma.cwiseAbs2().asDiagonal();
    } else {
      book.step(0.5L, Vector3(0.3L, -0.2L, 0.5L), 0.1L, 0.02L);
    }
    const auto z = seen_at(k);
    book.see_bias(Vector3(z[0], z[1], z[2]), 0.2L);
    const VectorXd x = state_of(session);
    const Quaternion q(x[0], x[1], x[2], x[3]);
    CHECK(double(turn_from(q, book.q).norm()) < 1e-9);
    CHECK((x.tail<3>() - book.b.cast<double>()).norm() < 1e-9);
    CHECK((log.P - book.P.cast<double>()).norm() < 1e-9 * log.P.norm());
    // What a smoother goes back by.
    if (k > 0) CHECK((log.Phi * log.P0 - book.cross.cast<double>()).norm() < 1e-9 * log.P0.norm());
    distance = std::max(distance, (log.P - of_ekf.P).norm() / log.P.norm());
  }
  CHECK(log.worst < 1e-12);
  CHECK(distance > 0.01);  // it was a test
  CHECK(session.notes({0}).empty());
}

// ---- where sigma points can not be had

TEST_CASE("a point that a model refuses: the step takes the Jacobians, and is counted in a note") {
  Session session = session_of(spinning_with(unscented, "0.2, 0.3, 0.1", R"(, "most": "0.3 rad/s")"));
  Session ekf = session_of(spinning_with(""));
  Log log, of_ekf;
  session.attach({0}, &log);
  ekf.attach({0}, &of_ekf);
  for (int k = 0; k < 2; ++k)
    for (Session* each : {&session, &ekf}) push(*each, "z", 0.5 * k, seen_at(k));
  // The bias is known to 0.14 by now, and 0.3 is less than √6 of that away.
  CHECK(state_of(session) == state_of(ekf));
  CHECK((log.P - of_ekf.P).norm() < 1e-14);
  CHECK((log.Phi - of_ekf.Phi).norm() == 0);
  CHECK((log.Qd - of_ekf.Qd).norm() == 0);
  const std::string notes = session.notes({0}).text();
  INFO(notes);
  CHECK(notes.find("a sigma point was refused, so the step used the Jacobians: the bias is too large") !=
        std::string::npos);
  CHECK(notes.find("spin") != std::string::npos);
  for (int k = 2; k < 40; ++k) push(session, "z", 0.5 * k, {0, 0, 0});
  CHECK(session.healthy({0}));  // the centre is not refused, and points are near it in the end
  const std::string later = session.notes({0}).text();
  push(session, "z", 20, {0, 0, 0});
  CHECK(session.notes({0}).text() == later);
}

TEST_CASE("sigma points that wrap around: the step takes the Jacobians, and says so") {
  std::string text = spinning_with(unscented);
  text.replace(text.find("[0.3, 0.2, 0.4]"), 15, "[0.3, 0.2, 1.5]");
  Session session = session_of(text);
  push(session, "z", 0, {0, 0, 0});
  push(session, "z", 1, {0, 0, 0});
  CHECK(session.healthy({0}));
  CHECK(session.notes({0}).text().find("beyond its chart") != std::string::npos);
}

TEST_CASE("along a path that is known Φ is the Jacobian: P stands still, so there is nothing to spread") {
  Session session = session_of(spinning_with(unscented)), ekf = session_of(spinning_with(""));
  Log log, of_ekf;
  session.attach({0}, &log);
  ekf.attach({0}, &of_ekf);
  for (Session* each : {&session, &ekf}) push(*each, "z", 0, {0, 0, 0});
  std::vector<double> path = {std::cos(0.3), std::sin(0.3), 0, 0, 0.1, 0, -0.1};
  log.path = of_ekf.path = path.data();
  const MatrixXd before = log.P;
  for (Session* each : {&session, &ekf}) push(*each, "z", 1, {0, 0, 0});
  CHECK(log.Phi == of_ekf.Phi);
  CHECK(log.Qd == of_ekf.Qd);
  CHECK(state_of(session) == state_of(ekf));
}

// ---- what must hold of every filter

TEST_CASE(
    "a filter with unscented propagation goes on from a snapshot to the bit, and allocates nothing in the run loop") {
  Session session = session_of(spinning_with(unscented));
  for (int k = 0; k < 5; ++k) push(session, "z", 0.5 * k, seen_at(k));
  std::vector<std::byte> kept(session.snapshot_size());
  session.snapshot(kept);
  for (int k = 5; k < 15; ++k) push(session, "z", 0.5 * k, seen_at(k));
  std::vector<std::byte> first(kept.size()), second(kept.size());
  session.snapshot(first);
  session.restore(kept);
  const auto before = conform::allocations();
  for (int k = 5; k < 15; ++k) push(session, "z", 0.5 * k, seen_at(k));
  const auto allocated = conform::allocations() - before;
  session.snapshot(second);
  CHECK(first == second);
  Session other = session_of(spinning_with(unscented));
  other.restore(kept);
  for (int k = 5; k < 15; ++k) push(other, "z", 0.5 * k, seen_at(k));
  other.snapshot(second);
  CHECK(first == second);
  if (!conform::allocations_are_counted()) return test::skip("with this C library allocations can not be counted");
  CHECK(allocated < 200);  // filter_tests::push looks its channel up and makes a vector
}

TEST_CASE("how a filter propagates is refused where it is no way") {
  std::string message;
  try {
    session_of(spinning_with(R"(, "propagation": "unscent")"));
  } catch (const Error& error) {
    message = error.what();
  }
  INFO(message);
  CHECK(message.find("'propagation' is \"ekf\" or \"unscented\"; found 'unscent'; did you mean 'unscented'?") !=
        std::string::npos);
  CHECK(message.find("/filters/f/propagation") != std::string::npos);
  CHECK_NOTHROW(session_of(spinning_with(R"(, "propagation": "ekf")")));
}

// ---- a process that is far from linear

namespace {

std::string driving(const std::string& propagation) {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"position": {"type": "vector", "size": 2, "unit": "m", "sigma": 0.1},
                 "heading": {"type": "vector", "size": 1, "unit": "rad", "sigma": "30 deg"}},
      "process": {"drive": {"type": "drive", "blocks": {"position": "position", "heading": "heading"}, "speed": 1,
                            "noise": 0.1, "turn_noise": 0.02}},
      "measurements": {"z": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "position"}, "sigma": [1e4]}})" +
         propagation + "}}}";
}

/// Mean NEES of position and heading over runs, of a vehicle drawn from what the filter believes, after each of so many steps;
/// nobody sees it.
std::vector<double> nees_of_driving(const std::string& propagation, int runs, double dt, int steps) {
  std::vector<double> sums(static_cast<std::size_t>(steps), 0.0);
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  const auto composition = composition_of(driving(propagation), SPIN_PLUGIN);
  for (int run = 0; run < runs; ++run) {
    Session session(composition);
    Log log;
    session.attach({0}, &log);
    Eigen::Vector3d truth(0.1 * normal(engine), 0.1 * normal(engine), 30 * M_PI / 180 * normal(engine));
    push(session, "z", 0, {0, 0});
    for (int k = 1; k <= steps; ++k) {
      truth[0] += dt * std::cos(truth[2]) + 0.1 * std::sqrt(dt) * normal(engine);
      truth[1] += dt * std::sin(truth[2]) + 0.1 * std::sqrt(dt) * normal(engine);
      truth[2] += 0.02 * std::sqrt(dt) * normal(engine);
      push(session, "z", dt * k, {truth[0], truth[1]});
      const Eigen::Vector3d error = truth - state_of(session);
      sums[static_cast<std::size_t>(k - 1)] += error.dot(log.P.ldlt().solve(error)) / runs;
    }
  }
  return sums;
}

}  // namespace

TEST_CASE("where a heading is known to 30 degrees, Jacobians make a filter overconfident and sigma points do not") {
  constexpr int runs = 400;
  const boost::math::chi_squared distribution(3 * runs);
  const double low = boost::math::quantile(distribution, 0.005) / runs,
               high = boost::math::quantile(boost::math::complement(distribution, 0.005)) / runs;
  std::printf("mean NEES of 3, %d runs, 99 %% band %.2f to %.2f\n  one step of, m  ekf  unscented\n", runs, low, high);
  for (const double dt : {1.0, 2.0, 5.0, 10.0}) {
    const double ekf = nees_of_driving("", runs, dt, 1).back(), points = nees_of_driving(unscented, runs, dt, 1).back();
    std::printf("  %g  %.2f  %.2f\n", dt, ekf, points);
    CHECK(ekf > 1.5 * high);
    CHECK(points > low);
    // Over a longer way what sin ψ − ψ leaves exceeds the noise, and a pair of points does not show it.
    CHECK(points < (dt <= 2 ? high : 0.2 * ekf));
  }
  // What the regression leaves is added as if it were another error each time. Here it is the same one, of a heading that
  // stays: better than Jacobians, and still overconfident. The documents say so.
  const double ekf = nees_of_driving("", runs, 1, 10).back(), points = nees_of_driving(unscented, runs, 1, 10).back();
  std::printf("  ten steps of 1 m  %.2f  %.2f\n", ekf, points);
  CHECK(points < 0.3 * ekf);
}

}  // namespace sigma_propagation_test
