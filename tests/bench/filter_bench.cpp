// SPDX-License-Identifier: Apache-2.0
// What a step, an update and an assembly cost, as ratios to dense fixed-size Eigen in the same run.
#include <cstdio>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <Eigen/Dense>

#include "binnacle/session.hpp"
#include "median_reporter.hpp"

using namespace binnacle;

namespace {

// An INS of n states: position, velocity, attitude; from 15 on gyro and accelerometer bias, from 21 on their scale
// factors; what remains are Gauss-Markov states in vectors of three that nothing reads.
std::string ins_config(int n, const std::string& order = "") {
  struct Optional {
    const char* name;
    const char* unit;
    const char* sigma;
    const char* process;
  };
  constexpr const char* bias_process = R"("type": "gauss_markov", "tau": "1 h", )";
  constexpr const char* constant_process = R"("type": "random_constant", )";
  const Optional optional[] = {{"gyro_bias", "rad/s", "10 deg/h", bias_process},
                               {"accel_bias", "m/s^2", "1 mg", bias_process},
                               {"gyro_scale", "1", "300 ppm", constant_process},
                               {"accel_scale", "1", "300 ppm", constant_process}};
  std::string blocks, process, ports;
  int states = 9;
  for (const auto& block : optional) {
    if (states + 3 > n) break;
    const std::string name = block.name;
    blocks += ", \"" + name + R"(": {"type": "vector", "size": 3, "unit": ")" + block.unit + R"(", "sigma": ")" +
              block.sigma + "\"}";
    const bool drifts = block.process == bias_process;
    process += ", \"of_" + name + "\": {" + block.process + R"("blocks": {"x": ")" + name + "\"}" +
               (drifts ? R"(, "sigma": ")" + std::string(block.sigma) + "\"" : "") + "}";
    ports += ", \"" + name + "\": \"" + name + "\"";
    states += 3;
  }
  for (int i = 0; states + 3 <= n; ++i, states += 3) {
    const std::string name = "extra" + std::to_string(i);
    blocks += ", \"" + name + R"(": {"type": "vector", "size": 3, "unit": "m", "sigma": 1})";
    process +=
        ", \"" + name + R"(": {"type": "gauss_markov", "blocks": {"x": ")" + name + R"("}, "tau": "1 h", "sigma": 1})";
  }
  const std::string order_text = order.empty() ? "" : R"(, "order": ")" + order + "\"";
  return R"({"binnacle": 1,
    "sources": {
      "imu": {"type": "pushed", "fields": {
        "wx": {"unit": "rad", "kind": "increment"}, "wy": {"unit": "rad", "kind": "increment"},
        "wz": {"unit": "rad", "kind": "increment"}, "fx": {"unit": "m/s", "kind": "increment"},
        "fy": {"unit": "m/s", "kind": "increment"}, "fz": {"unit": "m/s", "kind": "increment"}}},
      "gnss": {"type": "pushed", "fields": {
        "lat": {"unit": "rad"}, "lon": {"unit": "rad"}, "height": {"unit": "m"}}}},
    "filters": {"ins": {
      "blocks": {
        "position": {"type": "position", "init": {"lat": "48 deg", "lon": "11 deg", "height": 500}, "sigma": "5 m"},
        "velocity": {"type": "velocity", "init": {"vn": 3, "ve": 4, "vd": 0}, "sigma": "0.5 m/s"},
        "attitude": {"type": "attitude", "init": {"roll": 0, "pitch": 0, "yaw": "0.5 rad"}, "sigma": "1 deg"})" +
         blocks +
         R"(},
      "process": {
        "strapdown": {"type": "phi_error", "input": "imu",
          "blocks": {"position": "position", "velocity": "velocity", "attitude": "attitude")" +
         ports + R"(},
          "gyro_noise": 2.9e-5, "accel_noise": 5e-4)" +
         order_text + "}" + process + R"(},
      "measurements": {"fix": {"type": "position_fix", "channel": "gnss", "blocks": {"position": "position"},
                               "sigma": "2 m"}}}}})";
}

struct Ins {
  explicit Ins(int states, const std::string& order = "")
      : filter(Composition::parse(ins_config(states, order), "bench.json")),
        imu(filter.channel("imu")),
        gnss(filter.channel("gnss")) {
    for (int i = 0; i < 200; ++i) step();
  }
  void step() {
    filter.push(imu, t, t + interval, increments);
    t += interval;
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

constexpr int n = 21;
using Square = Eigen::Matrix<double, n, n>;

void dense_predict(benchmark::State& state) {
  Square Phi = Square::Identity() + 1e-3 * Square::Random();
  Square P = Square::Identity();
  const Square Q = 1e-6 * Square::Identity();
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

void assembly(benchmark::State& state) {
  const std::string text = ins_config(n);
  for (auto _ : state) benchmark::DoNotOptimize(Composition::parse(text, "bench.json"));
}

}  // namespace

BENCHMARK(dense_predict);
BENCHMARK(dense_joseph);
BENCHMARK(imu_step)->Arg(9)->Arg(15)->Arg(21)->Arg(30)->Arg(45)->Arg(60)->Arg(90)->Arg(120);
BENCHMARK(imu_step_first_order);
BENCHMARK(fix_update)->Arg(9)->Arg(15)->Arg(21)->Arg(30)->Arg(45)->Arg(60)->Arg(90)->Arg(120);
BENCHMARK(dense_ship_cycle);
BENCHMARK(ship_cycle);
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
  ratio("the same with the first-order transition", "imu_step_first_order", "dense_predict");
  ratio("3-row position fix, 21 states (model, gate, update)", "fix_update/21", "dense_joseph");
  ratio("ship filter, 4 states: 20 ms predicted, 1 row updated", "ship_cycle", "dense_ship_cycle");
  if (reporter.time_ns.contains("ship_cycle"))
    std::printf("the same in microseconds (paper 004, on a Z-8000 in 1984: 170 ms per gain cycle) %27.3f\n",
                1e-3 * reporter.time_ns["ship_cycle"]);
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
