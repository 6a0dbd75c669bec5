// SPDX-License-Identifier: Apache-2.0
// The vehicle simulator's errors against their statistics.
#include <array>
#include <cmath>
#include <vector>

#include "catch.hpp"
#include "simulated_drive.hpp"
#include "strapdown/rotation.hpp"

namespace vehicle_errors_test {

using namespace binnacle;
using namespace binnacle::simulated_drive;

namespace {

/// Standing, with only what `errors` names; the increments less those of a perfect run.
std::vector<Emitted> error_increments(double duration, const Json& errors, std::uint64_t seed, double rate = 100) {
  Json config = standing(duration);
  config["imu_rate"] = rate;
  config["gnss_rate"] = config["truth_rate"] = 0;
  for (const char* sensor : {"gyro", "accel"}) {
    config[sensor] = {{"bias", 0}, {"bias_instability", 0}, {"noise", 0}, {"scale", 0}};
    config[sensor].update(errors);
  }
  auto samples = Drive(config, seed).of(VehicleSimulator::imu);
  config["perfect"] = true;
  const auto exact = Drive(config, seed).of(VehicleSimulator::imu);
  for (std::size_t i = 0; i < samples.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k) samples[i].fields[k] -= exact[i].fields[k];
  return samples;
}

/// Errors in units of their standard deviations: the mean squares are 1, and no two are correlated.
template <std::size_t N>
class Scatter {
 public:
  void add(const std::array<double, N>& errors) {
    const Eigen::Map<const Eigen::Matrix<double, N, 1>> e(errors.data());
    sum_ += e * e.transpose();
    ++count_;
  }
  bool is_white() const {
    const auto n = static_cast<double>(count_);
    const auto identity = Eigen::Matrix<double, N, N>::Identity();
    // 4 σ of a mean square is 4 √(2/n), of a mean product 4/√n
    return ((sum_ / n - identity).array().abs() < 4.0 / std::sqrt(n) * (1.0 + 0.41 * identity.array())).all();
  }

 private:
  Eigen::Matrix<double, N, N> sum_ = Eigen::Matrix<double, N, N>::Zero();
  int count_ = 0;
};

/// Whether a mean square over n degrees of freedom lies within 4 σ of 1.
bool within_chi_squared(double mean_square, double n) { return std::abs(mean_square - 1.0) < 4.0 * std::sqrt(2.0 / n); }

}  // namespace

TEST_CASE("white noise has its density, at any rate, and no memory") {
  const double density = 2e-3;
  for (const double rate : {50.0, 200.0}) {
    const auto samples = error_increments(200, {{"noise", density}}, 4, rate);
    const auto n = static_cast<double>(samples.size());
    const double sigma = density / std::sqrt(rate);
    Scatter<6> scatter;
    for (const auto& sample : samples) {
      std::array<double, 6> errors{};
      for (std::size_t k = 0; k < 6; ++k) errors[k] = sample.fields[k] / sigma;
      scatter.add(errors);
    }
    REQUIRE(scatter.is_white());
    for (std::size_t k = 0; k < 6; ++k) {
      double neighbours = 0.0, walk = samples[0].fields[k];
      for (std::size_t i = 1; i < samples.size(); ++i) {
        neighbours += samples[i].fields[k] * samples[i - 1].fields[k];
        walk += samples[i].fields[k];
      }
      INFO("rate " << rate << ", field " << k);
      REQUIRE(std::abs(neighbours) < 4.0 * std::sqrt(n) * sigma * sigma);
      REQUIRE(std::abs(walk) < 4.0 * density * std::sqrt(200.0));
    }
  }
}

TEST_CASE("the constant errors have their deviations over runs and are the ones given as truth") {
  Json config = standing(1);
  config["imu_rate"] = 10;
  config["truth_rate"] = 1;
  for (const char* sensor : {"gyro", "accel"})
    config[sensor] = {{"bias", {1e-4, 2e-4, 3e-4}},
                      {"bias_instability", 0},
                      {"noise", 0},
                      {"scale", {0.01, 0.02, 0.03}}};
  Json perfect = config;
  perfect["perfect"] = true;
  const auto exact = Drive(perfect).of(VehicleSimulator::imu).front();
  Scatter<12> scatter;
  const int runs = 400;
  Drive drive(config);
  for (std::uint64_t run = 0; run < runs; ++run) {
    drive.restart(run);
    std::optional<Emitted> truth, imu;
    while (!truth || !imu) {
      auto sample = drive.next();
      if (sample->channel == VehicleSimulator::truth && !truth) truth = sample;
      if (sample->channel == VehicleSimulator::imu) imu = sample;
    }
    std::array<double, 12> errors{};
    for (std::size_t k = 0; k < 6; ++k) {
      const double bias = truth->fields[9 + k], scale = truth->fields[15 + k];
      REQUIRE(std::abs(imu->fields[k] - (exact.fields[k] * (1 + scale) + 0.1 * bias)) < 1e-15);
      const double axis = static_cast<double>(k % 3 + 1);
      errors[k] = bias / (1e-4 * axis);
      errors[6 + k] = scale / (0.01 * axis);
    }
    scatter.add(errors);
  }
  REQUIRE(scatter.is_white());
}

TEST_CASE("the wandering bias is a stationary Gauss-Markov process") {
  const double sigma = 1e-3, tau = 0.5, rate = 100;
  const auto samples = error_increments(1000, {{"bias_instability", sigma}, {"tau", tau}}, 8, rate);
  const auto n = samples.size();
  for (std::size_t k = 0; k < 6; ++k) {
    const auto correlation = [&](std::size_t lag) {
      double sum = 0.0;
      for (std::size_t i = lag; i < n; ++i) sum += samples[i].fields[k] * samples[i - lag].fields[k];
      return sum * rate * rate / (sigma * sigma) / static_cast<double>(n - lag);
    };
    // var of the estimated autocovariance at any lag is at most about 2 τ σ⁴ (1 + …)/T: 4 σ with some room
    const double band = 4.0 * std::sqrt(2.0 * tau / 1000.0);
    for (const std::size_t lag : {std::size_t{0}, std::size_t{25}, std::size_t{50}, std::size_t{100}}) {
      INFO("field " << k << ", lag " << lag << ": " << correlation(lag));
      REQUIRE(std::abs(correlation(lag) - std::exp(-static_cast<double>(lag) / rate / tau)) < band);
    }
  }
  double at_start = 0.0;
  const int runs = 300;
  for (std::uint64_t run = 0; run < runs; ++run) {
    const auto first = error_increments(0.02, {{"bias_instability", sigma}, {"tau", "1 h"}}, run, rate).front();
    for (std::size_t k = 0; k < 6; ++k) at_start += std::pow(first.fields[k] * rate / sigma, 2) / (6 * runs);
  }
  REQUIRE(within_chi_squared(at_start, 6 * runs));
}

TEST_CASE("truth gives the wandering bias that the samples have, between them too") {
  Json config = standing(20);
  config["imu_rate"] = 10;
  config["truth_rate"] = 20;
  for (const char* sensor : {"gyro", "accel"})
    config[sensor] = {{"bias", 1e-3}, {"bias_instability", 1e-3}, {"tau", "1 s"}, {"noise", 0}, {"scale", 0}};
  const auto samples = Drive(config, 2).rest();
  config["perfect"] = true;
  const auto exact = Drive(config).of(VehicleSimulator::imu);
  std::map<Time, Emitted> truth;
  for (const auto& sample : samples)
    if (sample.channel == VehicleSimulator::truth) truth.emplace(sample.t, sample);
  std::size_t i = 0;
  for (const auto& sample : samples) {
    if (sample.channel != VehicleSimulator::imu) continue;
    for (std::size_t k = 0; k < 6; ++k) {
      const double mean = (sample.fields[k] - exact[i].fields[k]) / 0.1;
      REQUIRE(std::abs(mean - truth.at((sample.t + sample.t0) / 2).fields[9 + k]) < 1e-12);
      REQUIRE(std::abs(mean - (truth.at(sample.t).fields[9 + k] + truth.at(sample.t0).fields[9 + k]) / 2) < 1e-12);
    }
    ++i;
  }
  REQUIRE(i == 200);
}

TEST_CASE("fixes scatter as configured and state what is specified") {
  Json config = standing(1000);
  config["imu_rate"] = 1;
  config["gnss_rate"] = 5;
  config["gnss"] = {{"position_sigma", {1, 2, 4}}, {"velocity_sigma", {0.1, 0.2, 0.4}}};
  const auto fixes = Drive(config, 3).of(VehicleSimulator::gnss);
  REQUIRE(fixes.size() == 5001);
  const Vector3d lla(48.1 * degree, 11.6 * degree, 520);
  Scatter<6> scatter;
  for (const auto& fix : fixes) {
    const Vector3d p = strapdown::position_minus(fix.triple(0), lla), v = fix.triple(3);
    scatter.add({p[0], p[1] / 2, p[2] / 4, v[0] / 0.1, v[1] / 0.2, v[2] / 0.4});
    REQUIRE(fix.triple(6) == Vector3d(1, 2, 4));
    REQUIRE(fix.triple(9) == Vector3d(0.1, 0.2, 0.4));
  }
  REQUIRE(scatter.is_white());

  config["segments"][0]["duration"] = 1;
  config["perfect"] = true;
  config["gnss"]["reported_velocity_sigma"] = "7 m/s";
  const auto perfect = Drive(config).of(VehicleSimulator::gnss).front();
  REQUIRE(metres(perfect.triple(0), lla) < 1e-8);
  REQUIRE(perfect.triple(3).norm() == 0.0);
  REQUIRE(perfect.triple(6) == Vector3d(1, 2, 4));
  REQUIRE(perfect.triple(9) == Vector3d(7, 7, 7));
}

TEST_CASE("the initial estimate has the errors that its covariance states") {
  Json config = lively_drive(1);
  config["perfect"] = false;
  config["start"]["speed"] = 3;
  config["segments"] = Json::array({{{"do", "straight"}, {"duration", 1}}});
  config["initial_sigma"] = {{"position", {1, 2, 3}},
                             {"velocity", {0.1, 0.2, 0.3}},
                             {"tilt", "1 deg"},
                             {"heading", "5 deg"}};
  Drive drive(config);
  const auto& names = drive.channels()[VehicleSimulator::initial].covariance;
  REQUIRE(names.size() == 9);
  REQUIRE(names[0].name == "position.north");
  REQUIRE(names[5].name == "velocity.down");
  REQUIRE(names[5].unit == "m/s");
  REQUIRE(names[8].name == "attitude.down");

  const std::array<double, 9> sigma = {1, 2, 3, 0.1, 0.2, 0.3, degree, degree, 5 * degree};
  Scatter<9> scatter;
  const int runs = 1000;
  for (std::uint64_t run = 0; run < runs; ++run) {
    drive.restart(run);
    const auto initial = drive.next();
    const auto truth = drive.next();
    REQUIRE(truth->channel == VehicleSimulator::truth);
    Eigen::Matrix<double, 9, 1> delta;  // truth ⊟ estimate
    delta << strapdown::position_minus(truth->triple(0), initial->triple(0)), truth->triple(3) - initial->triple(3),
        strapdown::attitude_minus(strapdown::quaternion_from_euler(truth->triple(6)),
                                  strapdown::quaternion_from_euler(initial->triple(6)));
    std::array<double, 9> errors{};
    for (std::size_t i = 0; i < 9; ++i) {
      errors[i] = delta[static_cast<int>(i)] / sigma[i];
      for (std::size_t j = 0; j < 9; ++j)
        REQUIRE(std::abs(initial->covariance[9 * i + j] - (i == j ? sigma[i] * sigma[i] : 0.0)) < 1e-15);
    }
    scatter.add(errors);
  }
  REQUIRE(scatter.is_white());
}

}  // namespace vehicle_errors_test
