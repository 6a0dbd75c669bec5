// SPDX-License-Identifier: Apache-2.0
// What an update of each attitude algorithm costs: the update alone, and a step of a mechanization with 9 and 21 states.
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "attitude/algorithm.hpp"
#include "binnacle/session.hpp"
#include "median_reporter.hpp"

using namespace binnacle;
using Eigen::Vector3d;

namespace {

struct Named {
  const char* name;
  int samples;
  const char* json;  // of "attitude", behind "samples"
  attitude::Form form = attitude::Form::coning;
  attitude::Update update = {};
};
const Named algorithms[] = {
    {"1 sample and the previous", 1, ""},
    {"2 samples", 2, ""},
    {"3 samples", 3, ""},
    {"4 samples", 4, ""},
    {"4 samples, polynomial", 4, R"(, "form": "polynomial")", attitude::Form::polynomial},
    {"4 samples, float", 4, R"(, "precision": "float")", attitude::Form::coning, {attitude::Precision::float_, {}}},
    {"4 samples, 2 terms",
     4,
     R"(, "truncation": "terms_2")",
     attitude::Form::coning,
     {attitude::Precision::double_, attitude::Truncation::after_terms(2)}},
};

/// Rotation vector and quaternion.
void update(benchmark::State& state, const Named& named) {
  attitude::Algorithm::Choice choice;
  choice.samples = named.samples, choice.form = named.form, choice.update = named.update;
  const attitude::Algorithm algorithm(choice);
  std::array<Vector3d, 4> theta = {Vector3d(0.01, 0.02, 0.03), Vector3d(0.012, 0.018, 0.03),
                                   Vector3d(0.014, 0.016, 0.03), Vector3d(0.016, 0.014, 0.03)};
  const std::array<double, 4> lengths = {0.005, 0.005, 0.005, 0.005};
  const auto count = static_cast<std::size_t>(named.samples);
  Eigen::Vector4d q(1, 0, 0, 0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(theta.data());
    attitude::IntervalWeights storage;
    const Vector3d phi = count == 1 ? algorithm.rotation(theta[0], 0.005, Vector3d(2, 4, 6), 0.005)
                                    : algorithm.rotation(std::span(theta).first(count),
                                                         algorithm.weights(std::span(lengths).first(count), storage));
    q = algorithm.update()(q, phi);
    benchmark::DoNotOptimize(q.data());
    benchmark::ClobberMemory();
  }
}

/// Intervals that differ: the weights are made for each update.
void uneven_update(benchmark::State& state) {
  attitude::Algorithm::Choice choice;
  choice.samples = 4;
  const attitude::Algorithm algorithm(choice);
  const std::array<Vector3d, 4> theta = {Vector3d(0.01, 0.02, 0.03), Vector3d(0.012, 0.018, 0.03),
                                         Vector3d(0.014, 0.016, 0.03), Vector3d(0.016, 0.014, 0.03)};
  std::array<double, 4> lengths = {0.005, 0.006, 0.005, 0.004};
  Eigen::Vector4d q(1, 0, 0, 0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(lengths.data());
    attitude::IntervalWeights storage;
    q = algorithm.update()(q, algorithm.rotation(theta, algorithm.weights(lengths, storage)));
    benchmark::DoNotOptimize(q.data());
    benchmark::ClobberMemory();
  }
}

std::string config(const Named& named, int states) {
  const std::string samples = std::to_string(named.samples);
  std::string blocks, ports, process;
  if (states == 21)
    for (const auto& [name, unit] :
         {std::pair("gyro_bias", "rad/s"), {"accel_bias", "m/s^2"}, {"gyro_scale", "1"}, {"accel_scale", "1"}}) {
      const std::string block = name;
      blocks += ", \"" + block + R"(": {"type": "vector", "size": 3, "unit": ")" + unit + R"(", "sigma": 1e-4})";
      ports += ", \"" + block + "\": \"" + block + "\"";
      process += ", \"of_" + block + R"(": {"type": "random_constant", "blocks": {"x": ")" + block + "\"}}";
    }
  return R"({"binnacle": 1,
    "sources": {"imu": {"type": "pushed", "fields": {
      "wx": {"unit": "rad", "kind": "increment"}, "wy": {"unit": "rad", "kind": "increment"},
      "wz": {"unit": "rad", "kind": "increment"}, "fx": {"unit": "m/s", "kind": "increment"},
      "fy": {"unit": "m/s", "kind": "increment"}, "fz": {"unit": "m/s", "kind": "increment"}}}},
    "filters": {"ins": {
      "blocks": {
        "position": {"type": "position", "init": {"lat": "48 deg", "lon": "11 deg", "height": 500}, "sigma": "5 m"},
        "velocity": {"type": "velocity", "init": {"vn": 3, "ve": 4, "vd": 0}, "sigma": "0.5 m/s"},
        "attitude": {"type": "attitude", "init": {"roll": 0, "pitch": 0, "yaw": "0.5 rad"}, "sigma": "1 deg"})" +
         blocks + R"(},
      "process": {"strapdown": {"type": "phi_error", "input": "imu", "gyro_noise": 2.9e-5, "accel_noise": 5e-4,
        "blocks": {"position": "position", "velocity": "velocity", "attitude": "attitude")" +
         ports + R"(},
        "samples_per_step": )" +
         samples + R"(, "attitude": {"samples": )" + samples + named.json + "}}" + process + "}}}}";
}

/// All samples of one step pushed.
void step(benchmark::State& state, const Named& named, int states) {
  Session filter(Composition::parse(config(named, states), "bench.json"));
  const auto imu = filter.channel("imu");
  const double increments[6] = {1e-4, -2e-4, 5e-4, 0.002, 0.001, -0.04904};
  constexpr Time interval = 5'000'000;
  Time t = 0;
  for (auto _ : state)
    for (int i = 0; i < named.samples; ++i, t += interval) filter.push(imu, t, t + interval, increments);
  if (!filter.healthy(FilterId{0})) state.SkipWithError(filter.diagnosis(FilterId{0}).c_str());
}

}  // namespace

int main(int argc, char** argv) {
  const auto name = [](const std::string& what, const Named& named) { return what + ", " + named.name; };
  for (const Named& named : algorithms) {
    benchmark::RegisterBenchmark(name("update", named).c_str(), [&named](benchmark::State& s) { update(s, named); });
    for (const int states : {9, 21})
      benchmark::RegisterBenchmark(name("step of " + std::to_string(states) + " states", named).c_str(),
                                   [&named, states](benchmark::State& s) { step(s, named, states); });
  }
  benchmark::RegisterBenchmark("update, 4 uneven samples", uneven_update);
  MedianReporter reporter;
  if (!run_interleaved(argc, argv, reporter)) return 2;

  std::printf("\n%-30s %28s %28s %28s\n", "", "update alone", "step of 9 states", "step of 21 states");
  std::printf("%-30s %28s %28s %28s\n", "", "ns, of one sample's", "ns, of one's, per sample",
              "ns, of one's, per sample");
  for (const Named& named : algorithms) {
    std::printf("%-30s", named.name);
    for (const char* what : {"update", "step of 9 states", "step of 21 states"}) {
      const double time = reporter.time_ns[name(what, named)], one = reporter.time_ns[name(what, algorithms[0])];
      std::printf("   %9.1f %7.2f", time, time / one);
      if (std::string(what) != "update")
        std::printf(" %7.2f", time / one / named.samples);
      else
        std::printf("        ");
    }
    std::printf("\n");
  }
  std::printf("%-30s   %9.1f %7.2f\n", "4 samples, uneven", reporter.time_ns["update, 4 uneven samples"],
              reporter.time_ns["update, 4 uneven samples"] / reporter.time_ns[name("update", algorithms[0])]);
  return 0;
}
