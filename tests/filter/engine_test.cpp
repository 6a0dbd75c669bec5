// SPDX-License-Identifier: Apache-2.0
// What the engine does, against dense textbook filters written out here.
#include <cmath>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/session.hpp"
#include "catch.hpp"

using namespace binnacle;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

Session session_of(const std::string& text) {
  LoadOptions options;
  options.sets = {"/plugins=[]", "/plugins/-=" PROBE_PLUGIN};
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  return Session(Composition::parse(text, "test.json", options));
}

void push(Session& filter, const char* channel, double t, std::vector<double> fields) {
  filter.push(filter.channel(channel), no_time, nanoseconds(t), fields);
}

MatrixXd dense(MatrixView view) { return view.as(); }

/// Position and velocity on a line: position integrates velocity, velocity wanders; position is measured.
std::string line(const std::string& blocks_extra = "", const std::string& measurement_extra = "",
                 const std::string& velocity_extra = "") {
  return R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {
        "position": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2},
        "velocity": {"type": "vector", "size": 1, "unit": "m/s", "init": 0.5, "sigma": 0.3)" +
         velocity_extra + R"(})" + blocks_extra + R"(},
      "process": {
        "move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
        "wander": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": 0.2}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "position"},
                               "sigma": [0.7])" +
         measurement_extra + R"(}}}}})";
}

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
      expected.advance(seconds(nanoseconds(t)) - filter.time(FilterId{0}) * 1e-9);
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
            (*more ? "process 'bad' cannot go on at 3 s: it is too late"
                   : "block 'x' is not finite at 3 s: plugin 'probe', component 'breaking' (/filters/f/process/bad): "
                     "propagate at 3 s gave 'x', which is not finite"));
    REQUIRE(filter.counts({{0}, 0}).by_outcome[0] == 3);
  }
}

namespace {

const std::string ins = R"({"binnacle": 1,
  "sources": {
    "imu": {"type": "pushed", "fields": {
      "wx": {"unit": "rad/s", "kind": "rate"}, "wy": {"unit": "rad/s", "kind": "rate"}, "wz": {"unit": "rad/s", "kind": "rate"},
      "fx": {"unit": "m/s^2", "kind": "rate"}, "fy": {"unit": "m/s^2", "kind": "rate"}, "fz": {"unit": "m/s^2", "kind": "rate"}}},
    "gnss": {"type": "pushed", "fields": {"lat": {"unit": "rad"}, "lon": {"unit": "rad"}, "height": {"unit": "m"}}}},
  "filters": {"ins": {
    "blocks": {
      "position": {"type": "position", "init": {"lat": "48 deg", "lon": "11 deg", "height": 500}, "sigma": "5 m"},
      "velocity": {"type": "velocity", "init": {"vn": 3, "ve": 4, "vd": 0}, "sigma": "0.5 m/s"},
      "attitude": {"type": "attitude", "init": {"roll": 0.1, "pitch": 0.05, "yaw": 0.5}, "sigma": "1 deg"},
      "gyro_bias": {"type": "vector", "size": 3, "unit": "rad/s", "sigma": "100 deg/h"},
      "accel_bias": {"type": "vector", "size": 3, "unit": "m/s^2", "sigma": "1 mg"}},
    "derived": {"antenna": {"type": "lever_arm", "blocks": {"position": "position", "attitude": "attitude"},
                            "lever_arm": ["1 m", "0.2 m", "-1.5 m"]}},
    "process": {
      "strapdown": {"type": "phi_error", "input": "imu",
        "blocks": {"position": "position", "velocity": "velocity", "attitude": "attitude",
                   "gyro_bias": "gyro_bias", "accel_bias": "accel_bias"},
        "gyro_noise": 2.9e-5, "accel_noise": 5e-4},
      "bg": {"type": "gauss_markov", "blocks": {"x": "gyro_bias"}, "tau": "1 h", "sigma": "100 deg/h"},
      "ba": {"type": "gauss_markov", "blocks": {"x": "accel_bias"}, "tau": "1 h", "sigma": "1 mg"}},
    "measurements": {"fix": {"type": "position_fix", "channel": "gnss", "blocks": {"position": "antenna"},
                             "sigma": "2 m"}}}}})";

struct InsDrive {
  explicit InsDrive(Session& f) : filter(f), imu(f.channel("imu")), gnss(f.channel("gnss")) {}
  void input(Time t0, Time t1) {
    const double s = seconds(t1);
    const double fields[] = {0.05 * std::sin(s), 0.02, 0.1 * std::cos(0.3 * s), 0.5, 1 + 0.2 * std::sin(2 * s), -9.8};
    filter.push(imu, t0, t1, fields);
  }
  void fix(Time t) {
    const double fields[] = {0.8377580409572782 + 1e-8 * seconds(t), 0.19198621771937624, 500};
    filter.push(gnss, no_time, t, fields);
  }
  Session& filter;
  ChannelId imu, gnss;
};

std::vector<std::byte> bytes_of(const Session& filter) {
  std::vector<std::byte> bytes(filter.snapshot_size());
  filter.snapshot(bytes);
  return bytes;
}

constexpr Time ms = 1'000'000;

}  // namespace

TEST_CASE("a measurement ahead of the input waits and splits the sample it falls into") {
  Session ahead = session_of(ins), split = session_of(ins);
  InsDrive a(ahead), b(split);
  for (int i = 0; i < 10; ++i) {
    a.input(i * 10 * ms, (i + 1) * 10 * ms);
    b.input(i * 10 * ms, (i + 1) * 10 * ms);
  }
  a.fix(104 * ms);  // not yet covered by input
  REQUIRE(ahead.counts({{0}, 0}).by_outcome[0] == 0);
  a.input(100 * ms, 110 * ms);
  REQUIRE(ahead.counts({{0}, 0}).by_outcome[0] == 1);
  REQUIRE(ahead.time(FilterId{0}) == 110 * ms);

  // The same with the sample cut by hand: equal rates over both pieces.
  const double s = seconds(110 * ms);
  const double fields[] = {0.05 * std::sin(s), 0.02, 0.1 * std::cos(0.3 * s), 0.5, 1 + 0.2 * std::sin(2 * s), -9.8};
  split.push(b.imu, 100 * ms, 104 * ms, fields);
  b.fix(104 * ms);
  split.push(b.imu, 104 * ms, 110 * ms, fields);
  REQUIRE((dense(ahead.covariance(FilterId{0})) - dense(split.covariance(FilterId{0}))).norm() <
          1e-6 * dense(split.covariance(FilterId{0})).norm());
  double pa[3], pb[3];
  ahead.read(ahead.block("position"), pa);
  split.read(split.block("position"), pb);
  REQUIRE(std::abs(pa[2] - pb[2]) < 1e-6);
  REQUIRE(std::abs(pa[0] - pb[0]) < 1e-12);
}

TEST_CASE("the queue of samples ahead of the input is bounded, and the overflow is told") {
  Session filter = session_of(ins);
  InsDrive drive(filter);
  drive.input(0, 10 * ms);
  for (int i = 0; i < 70; ++i) drive.fix((20 + i) * ms);
  REQUIRE(filter.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::rejected)] == 6);
  REQUIRE(filter.counts({{0}, 0}).last_reason == "the queue of samples ahead of the input is full");
}

TEST_CASE("samples of one instant may come in any order") {
  Session first = session_of(ins), last = session_of(ins);
  InsDrive a(first), b(last);
  for (int i = 0; i < 100; ++i) {
    a.input(i * 10 * ms, (i + 1) * 10 * ms);
    if (i % 10 == 9) a.fix((i + 1) * 10 * ms);
    if (i % 10 == 9) b.fix((i + 1) * 10 * ms);
    b.input(i * 10 * ms, (i + 1) * 10 * ms);
  }
  REQUIRE(first.counts({{0}, 0}).by_outcome[0] == 10);
  REQUIRE(last.counts({{0}, 0}).by_outcome[0] == 10);
  REQUIRE((dense(first.covariance(FilterId{0})).array() == dense(last.covariance(FilterId{0})).array()).all());
  REQUIRE(std::memcmp(first.state(FilterId{0}).data(), last.state(FilterId{0}).data(),
                      first.state(FilterId{0}).size_bytes()) == 0);
}

TEST_CASE("restored and continued equals uninterrupted, bit for bit") {
  auto run = [](Session& filter, int from, int to) {
    InsDrive drive(filter);
    for (int i = from; i < to; ++i) {
      drive.input(i * 10 * ms, (i + 1) * 10 * ms);
      if (i % 7 == 3) drive.fix((i + 1) * 10 * ms + 13 * ms);  // one always waits in the queue
    }
  };
  Session whole = session_of(ins);
  run(whole, 0, 300);
  Session first = session_of(ins);
  run(first, 0, 137);
  const auto saved = bytes_of(first);
  Session second = session_of(ins);
  run(second, 0, 20);  // another past, to be forgotten
  second.restore(saved);
  run(second, 137, 300);
  REQUIRE(bytes_of(whole) == bytes_of(second));

  SECTION("bytes of another composition are refused and nothing changes") {
    Session other = session_of(line());
    auto before = bytes_of(second);
    auto foreign = bytes_of(other);
    REQUIRE_THROWS_AS(second.restore(foreign), ConfigError);
    foreign = saved;
    foreign.pop_back();
    REQUIRE_THROWS_AS(second.restore(foreign), ConfigError);
    REQUIRE_THROWS_AS(second.restore(std::vector<std::byte>(10)), ConfigError);
    REQUIRE(bytes_of(second) == before);
  }
}

TEST_CASE("several input samples in a step: the measurement inside a group closes it") {
  const auto grouped = [](int samples) {
    std::string text = ins;
    const std::string key = R"("input": "imu",)";
    text.insert(text.find(key) + key.size(), " \"samples_per_step\": " + std::to_string(samples) + ",");
    return session_of(text);
  };
  Session one = grouped(1), four = grouped(4);
  InsDrive a(one), b(four);
  for (InsDrive* drive : {&a, &b})
    for (int i = 0; i < 200; ++i) {
      drive->input(i * 5 * ms, (i + 1) * 5 * ms);
      if (i % 25 == 11) drive->fix((i + 1) * 5 * ms);  // on a sample's end, inside a group
      if (i % 25 == 20)
        drive->fix((i + 1) * 5 * ms - 2 * ms);  // inside the sample just taken: late for one, not for four
    }
  REQUIRE(one.time(FilterId{0}) == 1000 * ms);
  // Up to three whole samples wait for their group.
  REQUIRE(four.time(FilterId{0}) <= 1000 * ms);
  REQUIRE(four.time(FilterId{0}) > 980 * ms);
  REQUIRE(one.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::late)] == 8);
  REQUIRE(four.counts({{0}, 0}).by_outcome[static_cast<int>(Outcome::late)] < 8);
  double pa[3], pb[3];
  one.read(one.block("attitude"), pa);
  four.read(four.block("attitude"), pb);
  for (int i = 0; i < 3; ++i) REQUIRE(std::abs(pa[i] - pb[i]) < 1e-2);
}

TEST_CASE("a hole in the input is bridged with the rates held, and counted") {
  Session filter = session_of(ins);
  InsDrive drive(filter);
  for (int i = 0; i < 10; ++i) drive.input(i * 10 * ms, (i + 1) * 10 * ms);
  drive.input(150 * ms, 160 * ms);
  REQUIRE(filter.time(FilterId{0}) == 160 * ms);
  REQUIRE(filter.healthy(FilterId{0}));
}

namespace {

/// `ins` with groups of `samples` for the attitude, from rates or from increments.
Session in_groups(int samples, bool of_increments) {
  std::string text = ins;
  const std::string key = R"("input": "imu",)";
  const std::string n = std::to_string(samples);
  text.insert(text.find(key) + key.size(), " \"samples_per_step\": " + n + ", \"attitude\": {\"samples\": " + n + "},");
  const auto replace_all = [&](const std::string& from, const std::string& to) {
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
  };
  if (of_increments) {
    replace_all(R"("unit": "rad/s", "kind": "rate")", R"("unit": "rad", "kind": "increment")");
    replace_all(R"("unit": "m/s^2", "kind": "rate")", R"("unit": "m/s", "kind": "increment")");
  }
  return session_of(text);
}

/// A noisy swing at 100 Hz with samples from `first_lost` to `last_lost` missing.
void swing(Session& filter, int count, int first_lost, int last_lost, bool of_increments) {
  std::mt19937 engine(7);
  std::normal_distribution<double> normal;
  const auto imu = filter.channel("imu");
  for (int i = 0; i < count; ++i) {
    const double t = 0.01 * i, scale = of_increments ? 0.01 : 1.0;
    double fields[6] = {0.3 * std::sin(2 * t) + 0.002 * normal(engine),
                        0.2 * std::cos(3 * t) + 0.002 * normal(engine),
                        0.1 + 0.002 * normal(engine),
                        0.05 * normal(engine),
                        0.05 * normal(engine),
                        -9.8 + 0.05 * normal(engine)};
    for (double& field : fields) field *= scale;
    if (i < first_lost || i > last_lost) filter.push(imu, i * 10 * ms, (i + 1) * 10 * ms, fields);
  }
}

}  // namespace

TEST_CASE("a hole in the input is bridged alone, wherever in a group of samples it falls") {
  for (const bool of_increments : {false, true})
    for (int place = 0; place < 4; ++place) {
      CAPTURE(of_increments, place);
      Session one = in_groups(1, of_increments), four = in_groups(4, of_increments);
      // 1000 samples less the lost ones are no multiple of four plus `place`: both end at the same time.
      for (Session* filter : {&one, &four}) swing(*filter, 1000, 500 + place, 559 + place, of_increments);
      REQUIRE(four.healthy(FilterId{0}));
      REQUIRE(one.time(FilterId{0}) - four.time(FilterId{0}) <= 30 * ms);
      double a[3], b[3], u[3], v[3];
      one.read(one.block("attitude"), a);
      four.read(four.block("attitude"), b);
      one.read(one.block("velocity"), u);
      four.read(four.block("velocity"), v);
      // At most three samples wait for their group: 0.3 rad/s and 0.1 m/s^2 of noise for 30 ms, and no more.
      for (int i = 0; i < 3; ++i) REQUIRE(std::abs(a[i] - b[i]) < 0.012);
      for (int i = 0; i < 3; ++i) REQUIRE(std::abs(u[i] - v[i]) < 0.12);
    }
}

TEST_CASE("a hole inside the first group of increments is bridged by what came before it") {
  for (const int samples : {1, 4}) {
    CAPTURE(samples);
    Session filter = in_groups(samples, true);
    swing(filter, 100, 3, 9, true);
    REQUIRE(filter.healthy(FilterId{0}));
    REQUIRE(filter.time(FilterId{0}) >= 960 * ms);
  }
}
