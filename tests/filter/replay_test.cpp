// SPDX-License-Identifier: Apache-2.0
// The step log holds all that happens to P: a dense replay, from P of the start and the log alone, gives every P.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace replay_test {

using namespace binnacle;

namespace {

using Matrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// Position, velocity, attitude (whose injection turns the remaining error), considered accelerometer biases; a pair of
/// numbers seen by rows, one of which may be left out; and a number that is known exactly and measured exactly.
const std::string config = R"({"binnacle": 1,
  "sources": {
    "imu": {"type": "pushed", "fields": {
      "wx": {"unit": "rad/s", "kind": "rate"}, "wy": {"unit": "rad/s", "kind": "rate"}, "wz": {"unit": "rad/s", "kind": "rate"},
      "fx": {"unit": "m/s^2", "kind": "rate"}, "fy": {"unit": "m/s^2", "kind": "rate"}, "fz": {"unit": "m/s^2", "kind": "rate"}}},
    "gnss": {"type": "pushed", "fields": {"lat": {"unit": "rad"}, "lon": {"unit": "rad"}, "height": {"unit": "m"}}},
    "rows": {"type": "pushed", "max_rows": 8, "fields": {
      "key": {"unit": "1", "per_row": true}, "z": {"unit": "1", "per_row": true},
      "slope": {"unit": "1", "per_row": true}, "variance": {"unit": "1", "per_row": true}}},
    "exact": {"type": "pushed", "max_rows": 8, "fields": {
      "key": {"unit": "1", "per_row": true}, "z": {"unit": "1", "per_row": true},
      "slope": {"unit": "1", "per_row": true}, "variance": {"unit": "1", "per_row": true}}}},
  "filters": {"ins": {
    "blocks": {
      "position": {"type": "position", "init": {"lat": "48 deg", "lon": "11 deg", "height": 500}, "sigma": "5 m"},
      "velocity": {"type": "velocity", "init": {"vn": 3, "ve": 4, "vd": 0}, "sigma": "0.5 m/s"},
      "attitude": {"type": "attitude", "init": {"roll": 0.1, "pitch": 0.05, "yaw": 0.5}, "sigma": "3 deg"},
      "gyro_bias": {"type": "vector", "size": 3, "unit": "rad/s", "sigma": "100 deg/h"},
      "accel_bias": {"type": "vector", "size": 3, "unit": "m/s^2", "sigma": "1 mg", "consider": ["x", "y", "z"]},
      "pair": {"type": "vector", "size": 2, "unit": "1", "sigma": [10, 0.1]},
      "known": {"type": "vector", "size": 2, "unit": "1", "init": [1, 0], "sigma": 0}},
    "process": {
      "strapdown": {"type": "phi_error", "input": "imu",
        "blocks": {"position": "position", "velocity": "velocity", "attitude": "attitude",
                   "gyro_bias": "gyro_bias", "accel_bias": "accel_bias"},
        "gyro_noise": 2.9e-5, "accel_noise": 5e-4},
      "bg": {"type": "gauss_markov", "blocks": {"x": "gyro_bias"}, "tau": "1 h", "sigma": "100 deg/h"},
      "ba": {"type": "gauss_markov", "blocks": {"x": "accel_bias"}, "tau": "1 h", "sigma": "1 mg"},
      "wander": {"type": "random_walk", "blocks": {"x": "pair"}, "q": 0.1},
      "keep": {"type": "random_constant", "blocks": {"x": "known"}}},
    "measurements": {
      "fix": {"type": "position_fix", "channel": "gnss", "blocks": {"position": "position"}, "sigma": "2 m",
              "gate": 0.999, "recover": {"after": 3, "inflate": {"position.north": "20 m", "velocity.east": "1 m/s"}},
              "withhold": {"every": 10}},
      "pair": {"type": "rows", "channel": "rows", "blocks": {"x": "pair"}, "gate": {"probability": 0.9999, "by": "row"},
               "noise": {"type": "huber", "by": "row"}},
      "exact": {"type": "rows", "channel": "exact", "blocks": {"x": "known"}}}}}})";

/// Follows the log twice: from one event to the next, and from the start.
class Replay final : public StepObserver {
 public:
  explicit Replay(const FilterInfo& info) : info_(info) {}
  Wants wants() const override { return Wants::everything; }

  void started(Time, const double*, ConstMatrixView P) override {
    total_ = last_ = P.as().cast<long double>();
    ++events["started"];
  }
  void stepped(const StepRecord& record) override {
    const Matrix Phi = wide(record.Phi), Qd = wide(record.Qd);
    follow("stepped", record.P0, record.P1, [&](const Matrix& P) { return Matrix(Phi * P * Phi.transpose() + Qd); });
  }
  void offered(const UpdateRecord& record) override {
    const std::string name = info_.measurements[static_cast<std::size_t>(record.measurement)].name;
    ++events[name + " " + std::to_string(static_cast<int>(record.outcome))];
    if (record.left_out > 0) ++events["left out"];
    if (record.residual) {
      const Matrix S = wide(record.H) * last_ * wide(record.H).transpose() + wide(record.R);
      CHECK((S - wide(record.update_S)).norm() <= 1e-11 * S.norm());
      CHECK(std::isfinite(record.residual[0]));
    }
    if (record.outcome != Outcome::accepted) return;
    if (record.reset) ++events["reset"];
    const Matrix H = wide(record.H), R = wide(record.R), K = wide(record.K);
    check_gain(record, H, K);
    const Matrix T = record.reset ? wide(record.reset) : Matrix::Identity(info_.dof, info_.dof);
    const Matrix A = Matrix::Identity(info_.dof, info_.dof) - K * H;
    follow("accepted", record.P0, record.P1, [&](const Matrix& P) {
      return Matrix(T * (A * P * A.transpose() + K * R * K.transpose()) * T.transpose());
    });
  }
  void inflated(const InflationRecord& record) override {
    follow("inflated", record.P0, record.P1, [&](Matrix P) {
      for (int i = 0; i < info_.dof && record.variances; ++i) P(i, i) += record.variances[i];
      for (int j = 0; j < info_.dof && record.scales; ++j)
        for (int i = 0; i < info_.dof; ++i)
          P(i, j) *= static_cast<long double>(record.scales[i]) * static_cast<long double>(record.scales[j]);
      if (record.scales) ++events["opened"];
      return P;
    });
  }

  std::map<std::string, int> events;
  double worst_step = 0, worst_total = 0;  // |ΔP_ij| / √(P_ii P_jj)
  bool is_gapless = true;

 private:
  static Matrix wide(ConstMatrixView view) { return view.as().cast<long double>(); }

  template <class Change>
  void follow(const char* event, ConstMatrixView P0, ConstMatrixView P1, Change&& change) {
    ++events[event];
    is_gapless = is_gapless && (wide(P0).array() == last_.array()).all();
    const Matrix P = wide(P1);
    worst_step = std::max(worst_step, distance(change(last_), P));
    total_ = change(total_);
    worst_total = std::max(worst_total, distance(total_, P));
    last_ = P;
  }
  static double distance(const Matrix& replayed, const Matrix& P) {
    long double worst = 0;
    for (Eigen::Index j = 0; j < P.cols(); ++j)
      for (Eigen::Index i = 0; i < P.rows(); ++i) {
        const long double difference = std::abs(replayed(i, j) - P(i, j));
        if (difference > 0) worst = std::max(worst, difference / std::sqrt(P(i, i) * P(j, j)));
      }
    return static_cast<double>(worst);
  }
  void check_gain(const UpdateRecord& record, const Matrix& H, const Matrix& K) {
    Matrix expected = last_ * H.transpose() * wide(record.update_S).inverse();
    for (const auto& block : info_.blocks)
      for (std::size_t a = 0; a < block.active.size(); ++a)
        if (block.use[static_cast<std::size_t>(block.active[a])] == "considered")
          expected.row(block.first_row + static_cast<Eigen::Index>(a)).setZero();
    CHECK((expected - K).norm() <= 1e-9 * (1 + expected.norm()));
  }

  const FilterInfo& info_;
  Matrix total_, last_;  // replayed from the start; the filter's after the last event
};

constexpr Time ms = 1'000'000;

/// Five minutes at 50 Hz. Fixes are taken of the filter's own estimate, so that it accepts them, but for some.
void drive(Session& session) {
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  const ChannelId imu = session.channel("imu"), gnss = session.channel("gnss"), rows = session.channel("rows");
  for (int i = 0; i < 15000; ++i) {
    const Time t = (i + 1) * 20 * ms;
    const double s = seconds(t);
    const double rates[] = {0.02 * std::sin(s),      0.01 * std::cos(0.7 * s), 0.1 * std::cos(0.3 * s),
                            0.5 * std::sin(0.2 * s), 0.3 * std::cos(0.1 * s),  -9.8 + 0.1 * normal(engine)};
    session.push(imu, t - 20 * ms, t, rates);
    if (i % 50 == 20) {
      double fix[3];
      session.read(session.block("position"), fix);
      fix[0] += (i / 50 % 40 >= 36 ? 200 : normal(engine)) / 6.4e6;
      fix[2] += 2 * normal(engine);
      session.push(gnss, no_time, t + (i % 100 == 20 ? 7 * ms : 0), fix);
    }
    if (i % 50 == 35) {
      double pair[2];
      session.read(session.block("pair"), pair);
      std::vector<double> list;
      for (int r = 0; r < 4; ++r) {
        const bool has_jumped = i > 12000;  // all rows: the state is wrong, and recovers
        const double slope = r - 1.5, outlier = has_jumped ? 30 : r == 2 && i % 500 == 35 ? 50 : 0;
        for (const double value : {1.0 + r, pair[0] + slope * pair[1] + normal(engine) + outlier, slope, 1.0})
          list.push_back(value);
      }
      SampleView sample;
      sample.t = t;
      sample.rows = 4;
      sample.row_fields = list.data();
      session.push(rows, sample);
      const double exact[] = {1, 1, 0, 0};
      sample.rows = 1;
      sample.row_fields = exact;
      session.push(session.channel("exact"), sample);
    }
  }
}

}  // namespace

TEST_CASE("a dense replay from the start and the step log alone gives every P") {
  const std::string form = GENERATE("joseph", "ud", "square_root");
  CAPTURE(form);
  const auto composition = filter_tests::composition_of(filter_tests::with_form(config, form));
  Session session(composition);
  Replay replay(composition->filters()[0]);
  session.attach(FilterId{0}, &replay);
  drive(session);
  REQUIRE(session.healthy(FilterId{0}));
  for (const auto& [event, count] : replay.events) UNSCOPED_INFO(event << ": " << count);
  INFO("from event to event " << replay.worst_step << ", over all " << replay.worst_total);
  CHECK(replay.events["stepped"] > 15000);
  CHECK(replay.events["inflated"] >= session.counts({{0}, 0}).recoveries + session.counts({{0}, 1}).recoveries);
  for (const char* event :
       {"inflated", "opened", "reset", "left out", "fix 0", "fix 1", "fix 5", "pair 0", "exact 6"}) {
    CAPTURE(event);
    CHECK(replay.events[event] > 0);
  }
  CHECK(replay.is_gapless);
  CHECK(replay.worst_step <= 1e-12);
  CHECK(replay.worst_total <= 1e-8);
}

}  // namespace replay_test
