// SPDX-License-Identifier: Apache-2.0
// What a step, an update and an assembly cost, as ratios to dense fixed-size Eigen in the same run.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <Eigen/Dense>

#include "binnacle/session.hpp"
#include "ins_config.hpp"
#include "median_reporter.hpp"

using namespace binnacle;

using bench::ins_config;

namespace {

struct Ins {
  explicit Ins(int states, const std::string& order = "", const std::string& update = "ekf")
      : filter(Composition::parse(ins_config(states, order), "bench.json", by(update))),
        imu(filter.channel("imu")),
        gnss(filter.channel("gnss")) {
    for (int i = 0; i < 200; ++i) step();
  }
  void step() {
    filter.push(imu, t, t + interval, increments);
    t += interval;
  }
  static LoadOptions by(const std::string& update) {
    LoadOptions options;
    if (update != "ekf") options.sets = {"/filters/ins/measurements/fix/update=\"" + update + "\""};
    return options;
  }
  void fix() { filter.push(gnss, no_time, t, position); }

  static constexpr Time interval = 5'000'000;
  Session filter;
  ChannelId imu, gnss;
  Time t = 0;
  double increments[6] = {1e-4, -2e-4, 5e-4, 0.002, 0.001, -0.04904};
  double position[3] = {0.8377580409572782, 0.19198621771937624, 500};
};

// Session A of paper 004: pitch and its rate in waves, a gyro's error and drift, read every 20 ms.
const char* const ship_config = R"({"binnacle": 1,
  "sources": {"vertical": {"type": "pushed", "fields": {"pitch": {"unit": "rad"}}}},
  "filters": {"ship": {
    "blocks": {
      "pitch": {"type": "vector", "size": 1, "unit": "rad", "init": 0, "sigma": "0.825 deg"},
      "pitch_rate": {"type": "vector", "size": 1, "unit": "rad/s", "init": 0, "sigma": "1.6335 deg/s"},
      "error": {"type": "vector", "size": 1, "unit": "rad", "init": 0, "sigma": 0},
      "drift": {"type": "vector", "size": 1, "unit": "rad/s", "init": 0, "sigma": "60 deg/h"}},
    "process": {
      "motion": {"type": "motion", "blocks": {"angle": "pitch", "rate": "pitch_rate"}, "omega": [1.98], "zeta": [0.2235],
                 "sigma": "0.825 deg"},
      "accumulation": {"type": "integrated", "blocks": {"x": "error", "rate": "drift"}},
      "drifting": {"type": "gauss_markov", "blocks": {"x": "drift"}, "tau": "3600 s", "sigma": "60 deg/h"}},
    "measurements": {
      "vertical": {"type": "vertical_gyro", "channel": "vertical", "blocks": {"pitch": "pitch", "pitch_error": "error"},
                   "sigma": "0.5 deg"}}}}})";

/// Prediction over 20 ms, Van Loan's discretization included, and the update.
void ship_cycle(benchmark::State& state) {
  Session filter(Composition::parse(ship_config, "bench.json"));
  const auto vertical = filter.channel("vertical");
  constexpr Time interval = 20'000'000;
  const double angle = 0.01;
  Time t = 0;
  for (auto _ : state) filter.push(vertical, no_time, t += interval, {&angle, 1});
  if (filter.counts({{0}, 0}).offered != filter.counts({{0}, 0}).by_outcome[0]) state.SkipWithError("not accepted");
}

/// The same numbers by dense fixed-size Eigen with Φ and Q known beforehand: the least that a cycle can be.
void dense_ship_cycle(benchmark::State& state) {
  using Matrix = Eigen::Matrix4d;
  Matrix Phi = Matrix::Identity(), P = Matrix::Identity();
  Phi(0, 1) = Phi(2, 3) = 0.02;
  Phi(1, 0) = -0.078;
  const Matrix Q = 1e-6 * Matrix::Identity();
  const Eigen::RowVector4d H(1, 0, 1, 0);
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  for (auto _ : state) {
    x = Phi * x;
    P = Phi * P * Phi.transpose() + Q;
    const Eigen::Vector4d K = P * H.transpose() / ((H * P * H.transpose()).value() + 7.6e-5);
    x += K * (0.01 - H * x);
    const Matrix A = Matrix::Identity() - K * H;
    P = A * P * A.transpose() + 7.6e-5 * K * K.transpose();
    benchmark::DoNotOptimize(P.data());
    benchmark::DoNotOptimize(x.data());
    benchmark::ClobberMemory();
  }
}

void empty_push(benchmark::State& state) {
  Session session(Composition::parse(bench::idle_config(), "bench.json"));
  const auto channel = session.channel("z");
  const double x = 1;
  Time t = 0;
  for (auto _ : state) session.push(channel, no_time, t += 1'000'000, {&x, 1});
  if (session.counts(channel).pushed != static_cast<std::int64_t>(state.iterations())) state.SkipWithError("not taken");
}

constexpr int n = 21;
template <int states>
using SquareOf = Eigen::Matrix<double, states, states>;
using Square = SquareOf<n>;

template <int states>
void dense_predict(benchmark::State& state) {
  using Own = SquareOf<states>;
  Own Phi = Own::Identity() + 1e-3 * Own::Random();
  Own P = Own::Identity();
  const Own Q = 1e-6 * Own::Identity();
  for (auto _ : state) {
    P = Phi * P * Phi.transpose() + Q;
    P *= 0.999;  // stays bounded
    benchmark::DoNotOptimize(P.data());
    benchmark::ClobberMemory();
  }
}

void dense_joseph(benchmark::State& state) {
  Square P = Square::Identity();
  Eigen::Matrix<double, 3, n> H = Eigen::Matrix<double, 3, n>::Zero();
  H.leftCols<3>().setIdentity();
  const Eigen::Matrix3d R = 4 * Eigen::Matrix3d::Identity();
  for (auto _ : state) {
    const Eigen::Matrix<double, n, 3> PHt = P * H.transpose();
    const Eigen::Matrix3d S = H * PHt + R;
    const Eigen::Matrix<double, n, 3> K = PHt * S.inverse();
    const Square A = Square::Identity() - K * H;
    P = A * P * A.transpose() + K * R * K.transpose();
    benchmark::DoNotOptimize(P.data());
    benchmark::ClobberMemory();
  }
}

void imu_step(benchmark::State& state) {
  Ins ins(static_cast<int>(state.range(0)));
  for (auto _ : state) ins.step();
  if (!ins.filter.healthy(FilterId{0})) state.SkipWithError(ins.filter.diagnosis(FilterId{0}).c_str());
}

void imu_step_first_order(benchmark::State& state) {
  Ins ins(n, "first");
  for (auto _ : state) ins.step();
}

void fix_update(benchmark::State& state) {
  Ins ins(static_cast<int>(state.range(0)));
  for (auto _ : state) ins.fix();
  if (ins.filter.counts({{0}, 0}).offered != ins.filter.counts({{0}, 0}).by_outcome[0])
    state.SkipWithError("not accepted");
}

/// A target of 4 states whose bearing is measured from a vessel that goes to and fro, once a second: predicted and updated.
void bearing_update(benchmark::State& state, const char* update) {
  Session filter(Composition::parse(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {
      "azimuth": {"unit": "rad"}, "observer_north": {"unit": "m"}, "observer_east": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"position": {"type": "vector", "size": 2, "unit": "m", "init": [5000, 0], "sigma": [500, 300]},
                 "velocity": {"type": "vector", "size": 2, "unit": "m/s", "init": 0, "sigma": 1}},
      "process": {"move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
                  "wander": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": 0.1}},
      "measurements": {"see": {"type": "bearing", "channel": "z", "blocks": {"target": "position"}, "sigma": "0.5 deg",
                               "update": ")" +
                                        std::string(update) + R"("}}}}})",
                                    "bench.json"));
  const auto z = filter.channel("z");
  Time t = 0;
  for (auto _ : state) {
    const auto k = static_cast<int>(t / nanoseconds_per_second);
    const double east = 10.0 * std::abs(k % 200 - 100), noise = 0.0087 * ((k * 7919) % 13 - 6) / 3.7;
    const double fields[] = {std::atan2(-east, 5000.0) + noise, 0, east};
    filter.push(z, no_time, t += nanoseconds_per_second, fields);
  }
  const auto counts = filter.counts({{0}, 0});
  if (counts.offered != counts.by_outcome[0]) state.SkipWithError("not accepted");
  if (counts.iterated > 0) state.counters["linearizations"] = double(counts.iterations) / double(counts.iterated);
}

/// The fix of Ins, of 21 states, by another update.
void fix_update_by(benchmark::State& state, const char* update) {
  Ins ins(n, "", update);
  for (auto _ : state) ins.fix();
  if (ins.filter.counts({{0}, 0}).offered != ins.filter.counts({{0}, 0}).by_outcome[0])
    state.SkipWithError("not accepted");
}

void assembly(benchmark::State& state) {
  const std::string text = ins_config(n);
  for (auto _ : state) benchmark::DoNotOptimize(Composition::parse(text, "bench.json"));
}

}  // namespace

BENCHMARK(dense_predict<n>)->Name("dense_predict");
BENCHMARK(dense_predict<15>)->Name("dense_predict_15");
BENCHMARK(dense_joseph);
BENCHMARK(imu_step)->Arg(9)->Arg(15)->Arg(21)->Arg(30)->Arg(45)->Arg(60)->Arg(90)->Arg(120);
BENCHMARK(imu_step_first_order);
BENCHMARK(fix_update)->Arg(9)->Arg(15)->Arg(21)->Arg(30)->Arg(45)->Arg(60)->Arg(90)->Arg(120);
BENCHMARK_CAPTURE(fix_update_by, iterated, "iterated");
BENCHMARK_CAPTURE(fix_update_by, unscented, "unscented");
BENCHMARK_CAPTURE(bearing_update, ekf, "ekf");
BENCHMARK_CAPTURE(bearing_update, iterated, "iterated");
BENCHMARK_CAPTURE(bearing_update, unscented, "unscented");
BENCHMARK(dense_ship_cycle);
BENCHMARK(ship_cycle);
BENCHMARK(empty_push);
BENCHMARK(assembly)->Unit(benchmark::kMillisecond);

int main(int argc, char** argv) {
  MedianReporter reporter;
  if (!run_interleaved(argc, argv, reporter)) return 2;

  const auto ratio = [&](const char* what, const std::string& name, const std::string& reference) {
    if (reporter.time_ns.contains(name) && reporter.time_ns.contains(reference))
      std::printf("%-58s %6.3f of %s\n", what, reporter.time_ns[name] / reporter.time_ns[reference], reference.c_str());
  };
#if defined(__x86_64__)
  std::printf("\nThe covariance arithmetic runs %s; the dense reference what this was compiled for.\n",
              __builtin_cpu_supports("avx2") ? "with AVX2, chosen at run time"
                                             : "without AVX2, which this processor lacks");
#endif
  ratio("IMU step, 21 states (mechanization, Phi, covariance)", "imu_step/21", "dense_predict");
  ratio("the same, 15 states", "imu_step/15", "dense_predict_15");
  ratio("21 states with the first-order transition", "imu_step_first_order", "dense_predict");
  ratio("3-row position fix, 21 states (model, gate, update)", "fix_update/21", "dense_joseph");
  for (const std::string update : {"iterated", "unscented"}) {
    ratio(("the same fix, " + update).c_str(), "fix_update_by/" + update, "fix_update/21");
    ratio(("bearing of a target, 4 states, " + update).c_str(), "bearing_update/" + update, "bearing_update/ekf");
  }
  ratio("ship filter, 4 states: 20 ms predicted, 1 row updated", "ship_cycle", "dense_ship_cycle");
  if (reporter.time_ns.contains("ship_cycle"))
    std::printf("the same in microseconds (paper 004, on a Z-8000 in 1984: 170 ms per gain cycle) %27.3f\n",
                1e-3 * reporter.time_ns["ship_cycle"]);
  if (reporter.time_ns.contains("empty_push"))
    std::printf("a push on a channel that nobody subscribes to, in nanoseconds %45.0f\n",
                reporter.time_ns["empty_push"]);
  for (const char* what : {"imu_step/", "fix_update/"}) {
    std::printf("%s n states, of 21:", what);
    for (const int states : {9, 15, 21, 30, 45, 60, 90, 120}) {
      const std::string name = what + std::to_string(states);
      if (reporter.time_ns.contains(name))
        std::printf("  %d: %.2f", states, reporter.time_ns[name] / reporter.time_ns[what + std::to_string(n)]);
    }
    std::printf("\n");
  }
  return 0;
}
