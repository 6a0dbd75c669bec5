// SPDX-License-Identifier: Apache-2.0
// Six noises of a simulated drive, from starts that are 30 times off: are they found, and is it known how well?
#include "catch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tune/tune.hpp"

namespace recovery_test {

using namespace binnacle;

namespace {

struct Truth {
  const char* pointer;
  double value;
  const char* unit;
};

constexpr std::array<Truth, 6> truths{{{"/filters/ins/process/strapdown/gyro_noise", 2e-3, " rad/s/sqrt(Hz)"},
                                       {"/filters/ins/process/strapdown/accel_noise", 0.05, " m/s^2/sqrt(Hz)"},
                                       {"/filters/ins/process/gyro_walk/q", 2e-4, " rad/s/sqrt(s)"},
                                       {"/filters/ins/process/accel_walk/q", 8e-3, " m/s^2/sqrt(s)"},
                                       {"/filters/ins/measurements/fix/stack/position/scale", 1, ""},
                                       {"/filters/ins/measurements/fix/stack/velocity/scale", 1, ""}}};
constexpr int seeds = 30;

struct Tuned {
  std::array<double, 6> error{}, sigma{};  // of ln θ
  int evaluations = 0;
  std::string trouble;
};

/// Each noise 30 times too large or too small, by the run's own draw.
Tuned tuned(int run) {
  std::mt19937 random(static_cast<unsigned>(run));
  LoadOptions load;
  for (const Truth& truth : truths) {
    const double start = truth.value * (random() % 2 ? 30 : 1 / 30.0);
    load.sets.push_back(std::string(truth.pointer) + "=" + tune::Json(start).dump() + truth.unit);
  }
  tune::TuneOptions options;
  options.run = run;
  Tuned result;
  try {
    const auto plan = tune::read_plan(BINNACLE_TEST_PROJECT "/tests/tune/ins.json", load);
    const auto json = tune::tune(plan, options);
    result.evaluations = json.at("evaluations");
    for (std::size_t p = 0; p < truths.size(); ++p) {
      const auto& parameter = json.at("parameters").at(p);
      if (!parameter.contains("end")) throw std::runtime_error(parameter.dump());
      const auto& end = parameter.at("end");
      const double value = end.is_string() ? std::stod(end.get<std::string>()) : end.get<double>();
      result.error[p] = std::log(value / truths[p].value);
      result.sigma[p] = parameter.at("standard_error");
    }
  } catch (const std::exception& error) {
    result.trouble = error.what();
  }
  return result;
}

}  // namespace

TEST_CASE("tune finds six noises from starts 30 times off, and knows how well") {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  std::vector<Tuned> all(seeds);
  std::vector<std::thread> threads;
  const int workers = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  for (int w = 0; w < workers; ++w)
    threads.emplace_back([&all, w, workers] {
      for (int run = w; run < seeds; run += workers) all[static_cast<std::size_t>(run)] = tuned(run);
    });
  for (auto& thread : threads) thread.join();

  std::vector<int> evaluations;
  for (int run = 0; run < seeds; ++run) {
    INFO(run);
    CHECK(all[static_cast<std::size_t>(run)].trouble == "");
    evaluations.push_back(all[static_cast<std::size_t>(run)].evaluations);
  }
  std::ranges::sort(evaluations);
  CHECK(evaluations[seeds / 2] <= 40);
  for (std::size_t p = 0; p < truths.size(); ++p) {
    int covered = 0;
    double mean = 0, squares = 0, sigma = 0;
    for (const Tuned& one : all) {
      covered += std::abs(one.error[p]) < 2 * one.sigma[p];
      mean += one.error[p] / seeds;
      sigma += one.sigma[p] / seeds;
    }
    for (const Tuned& one : all) squares += (one.error[p] - mean) * (one.error[p] - mean);
    const double scatter = std::sqrt(squares / (seeds - 1));
    INFO(truths[p].pointer << ": covered " << covered << ", scatter " << scatter << ", mean standard error " << sigma);
    CHECK(covered >= 26);
    CHECK(sigma < 1.5 * scatter);
    CHECK(scatter < 1.5 * sigma);
  }
}

}  // namespace recovery_test
