// SPDX-License-Identifier: Apache-2.0
// What a step, an update and an assembly cost, as ratios to dense fixed-size Eigen in the same run.
#include <cstdio>
#include <map>
#include <string>

#include <Eigen/Dense>
#include <benchmark/benchmark.h>

#include "binnacle/filter.hpp"

using namespace binnacle;

namespace {

// A 21-state INS (position, velocity, attitude, gyro and accelerometer bias and scale factor), and `extra` more
// Gauss-Markov states in vectors of three that nothing reads.
std::string ins_config(int extra, const std::string& order = "") {
  std::string blocks, process;
  for (int i = 0; i < extra / 3; ++i) {
    const std::string name = "extra" + std::to_string(i);
    blocks += ", \"" + name + R"(": {"type": "vector", "size": 3, "unit": "m", "sigma": 1})";
    process += ", \"" + name + R"(": {"type": "gauss_markov", "blocks": {"x": ")" + name +
               R"("}, "tau": "1 h", "sigma": 1})";
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
        "attitude": {"type": "attitude", "init": {"roll": 0, "pitch": 0, "yaw": "0.5 rad"}, "sigma": "1 deg"},
        "gyro_bias": {"type": "vector", "size": 3, "unit": "rad/s", "sigma": "10 deg/h"},
        "accel_bias": {"type": "vector", "size": 3, "unit": "m/s^2", "sigma": "1 mg"},
        "gyro_scale": {"type": "vector", "size": 3, "unit": "1", "sigma": "300 ppm"},
        "accel_scale": {"type": "vector", "size": 3, "unit": "1", "sigma": "300 ppm"})" + blocks + R"(},
      "process": {
        "strapdown": {"type": "phi_error", "input": "imu",
          "blocks": {"position": "position", "velocity": "velocity", "attitude": "attitude", "gyro_bias": "gyro_bias",
                     "accel_bias": "accel_bias", "gyro_scale": "gyro_scale", "accel_scale": "accel_scale"},
          "gyro_noise": 2.9e-5, "accel_noise": 5e-4)" + order_text + R"(},
        "bg": {"type": "gauss_markov", "blocks": {"x": "gyro_bias"}, "tau": "1 h", "sigma": "10 deg/h"},
        "ba": {"type": "gauss_markov", "blocks": {"x": "accel_bias"}, "tau": "1 h", "sigma": "1 mg"},
        "sg": {"type": "random_constant", "blocks": {"x": "gyro_scale"}},
        "sa": {"type": "random_constant", "blocks": {"x": "accel_scale"}})" + process + R"(},
      "measurements": {"fix": {"type": "position_fix", "channel": "gnss", "blocks": {"position": "position"},
                               "sigma": "2 m"}}}}})";
}

struct Ins {
  explicit Ins(int extra, const std::string& order = "")
      : filter(Composition::parse(ins_config(extra, order), "bench.json")),
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
  Filter filter;
  int imu, gnss;
  Time t = 0;
  double increments[6] = {1e-4, -2e-4, 5e-4, 0.002, 0.001, -0.04904};
  double position[3] = {0.8377580409572782, 0.19198621771937624, 500};
};

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
  if (!ins.filter.healthy(0)) state.SkipWithError(ins.filter.diagnosis(0).c_str());
}

void imu_step_first_order(benchmark::State& state) {
  Ins ins(0, "first");
  for (auto _ : state) ins.step();
}

void fix_update(benchmark::State& state) {
  Ins ins(static_cast<int>(state.range(0)));
  for (auto _ : state) ins.fix();
  if (ins.filter.counts(0, 0).offered != ins.filter.counts(0, 0).by_outcome[0]) state.SkipWithError("not accepted");
}

void assembly(benchmark::State& state) {
  const std::string text = ins_config(0);
  for (auto _ : state) benchmark::DoNotOptimize(Composition::parse(text, "bench.json"));
}

void vector_predict(benchmark::State& state) {
  // n states of which the INS part is fixed: what the rest costs.
  Ins ins(static_cast<int>(state.range(0)) - n);
  for (auto _ : state) ins.step();
}

class RatioReporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const auto& run : runs) time_ns[run.benchmark_name()] = run.GetAdjustedRealTime();
  }
  std::map<std::string, double> time_ns;
};

}  // namespace

BENCHMARK(dense_predict);
BENCHMARK(dense_joseph);
BENCHMARK(imu_step)->Arg(0);
BENCHMARK(imu_step_first_order);
BENCHMARK(fix_update)->Arg(0);
BENCHMARK(vector_predict)->Arg(30)->Arg(45)->Arg(60)->Arg(90)->Arg(120);
BENCHMARK(assembly)->Unit(benchmark::kMillisecond);

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  RatioReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  const auto ratio = [&](const char* what, const char* name, const char* reference) {
    if (reporter.time_ns.contains(name) && reporter.time_ns.contains(reference))
      std::printf("%-58s %6.3f of %s\n", what, reporter.time_ns[name] / reporter.time_ns[reference], reference);
  };
  std::printf("\n");
  ratio("IMU step, 21 states (mechanization, Phi, covariance)", "imu_step/0", "dense_predict");
  ratio("the same with the first-order transition", "imu_step_first_order", "dense_predict");
  ratio("3-row position fix, 21 states (model, gate, update)", "fix_update/0", "dense_joseph");
  return 0;
}
