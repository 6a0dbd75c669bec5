// SPDX-License-Identifier: Apache-2.0
// The coning simulator: increments against the motion that truth gives, on the earth and off it.
#include "../../plugins/coning_simulator/coning_motion.hpp"
#include "../../plugins/coning_simulator/simulator.hpp"
#include "binnacle/bind.hpp"
#include "binnacle/testing.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"

namespace coning_simulator_test {

using namespace binnacle;
using namespace binnacle::coning_simulator;
using Eigen::Vector3d;
using Eigen::Vector4d;
using nlohmann::json;

namespace {

std::unique_ptr<ConingSimulator> bound(const json& config) {
  return binnacle::testing::bind<ConingSimulator>({config});
}

struct Sample {
  int channel;
  Time t0, t;
  std::vector<double> fields;
};

std::vector<Sample> all_of(const json& parameters) {
  const auto source = bound(parameters);
  const binnacle::testing::SourceCaller caller(*source);
  auto memory = caller.fresh_memory(1);
  std::vector<Sample> samples;
  for (;;) {
    const auto next = caller.next(memory.data());
    REQUIRE(next.damage.empty());
    if (next.status == SourceStatus::end) return samples;
    samples.push_back({next.sample.channel, next.sample.t0, next.sample.t, next.sample.fields});
  }
}

Vector4d quaternion_of(const Sample& truth) {
  const std::size_t first = truth.fields.size() - 3;
  return strapdown::quaternion_from_euler({truth.fields[first], truth.fields[first + 1], truth.fields[first + 2]});
}

}  // namespace

TEST_CASE("coning: the rates are those of the attitude, by differences", "[coning]") {
  const ConingMotion motion({0.3, 4.0}, {}, std::nullopt);
  for (const double cycle : {0.0, 0.1, 0.37, 0.8}) {
    const double dt = 1e-4;
    const auto back = strapdown::quaternion_conjugate(motion.attitude(cycle - 2 * dt));
    // Halfway around half a millisecond: the small rotation itself is the increment, to third order.
    const Vector3d turned =
        strapdown::quaternion_log(strapdown::quaternion_product(back, motion.attitude(cycle + 2 * dt)));
    const Vector3d increment = motion.increments(cycle, 4 * dt / 4.0).omega_ib_b;
    CHECK((turned - increment).norm() < 1e-6 * increment.norm());
  }
  // Equation (8) with what the scan lost: the change over h turns by −sin²(ε/2) sin W h about the cone's axis.
  const double h = 0.02, W = 2 * std::numbers::pi * 4;
  const auto change = strapdown::quaternion_product(strapdown::quaternion_conjugate(motion.attitude(0.13)),
                                                    motion.attitude(0.13 + 4 * h));
  CHECK(std::abs(change[0] - (1 - 2 * std::pow(std::sin(0.15) * std::sin(W * h / 2), 2))) < 1e-15);
  CHECK(std::abs(change[1] + std::pow(std::sin(0.15), 2) * std::sin(W * h)) < 1e-15);
}

TEST_CASE("coning: increments add up whatever they are cut into, and labels are to the nanosecond", "[coning]") {
  json parameters{
      {"frequency", 7}, {"interval", 0.01}, {"duration", 2}, {"truth_rate", 0}, {"acceleration", {1, 2, 3}}};
  const auto whole = all_of(parameters);
  parameters["samples"] = 3;
  const auto thirds = all_of(parameters);
  REQUIRE(whole.size() == 200);
  REQUIRE(thirds.size() == 600);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    CHECK(thirds[3 * i].t0 == whole[i].t0);
    CHECK(thirds[3 * i + 2].t == whole[i].t);
    CHECK(std::abs(static_cast<double>(thirds[3 * i].t - thirds[3 * i].t0) - 1e7 / 3) < 1);
    for (std::size_t f = 0; f < 6; ++f) {
      const double sum = thirds[3 * i].fields[f] + thirds[3 * i + 1].fields[f] + thirds[3 * i + 2].fields[f];
      CHECK(std::abs(sum - whole[i].fields[f]) < 1e-16);
    }
  }
  CHECK(whole.back().t == nanoseconds(2));
  parameters["precision"] = "float";
  const auto single = all_of(parameters);
  for (std::size_t f = 0; f < 6; ++f) {
    CHECK(single[5].fields[f] == static_cast<double>(static_cast<float>(thirds[5].fields[f])));
    CHECK(single[5].fields[f] != thirds[5].fields[f]);
  }
}

TEST_CASE("coning: an hour later the phase has its digits still", "[coning]") {
  const auto source = bound({{"frequency", 25}, {"interval", 0.004}, {"duration", 4000}});
  const auto at = [&](std::int64_t sample) {
    const std::int64_t memory[2] = {sample, 1000000};
    std::vector<std::byte> bytes(sizeof memory);
    std::memcpy(bytes.data(), memory, sizeof memory);
    const auto next = binnacle::testing::SourceCaller(*source).next(bytes.data());
    REQUIRE(next.status == SourceStatus::sample);
    const auto& fields = next.sample.fields;
    return Vector3d(fields[0], fields[1], fields[2]);
  };
  // Ten samples are one cycle.
  CHECK((at(1) - at(900001)).norm() < 1e-14 * at(1).norm() * 100);
}

TEST_CASE("coning: on the earth the mechanization finds truth again", "[coning]") {
  const json parameters{{"frequency", 5}, {"interval", 0.0005},
                        {"duration", 2},  {"acceleration", {3, -2, 4}},
                        {"phase", 0.7},   {"place", {{"lat", 0.7}, {"lon", 2.2}, {"height", 100}}}};
  const auto samples = all_of(parameters);
  REQUIRE(samples[0].channel == ConingSimulator::truth);
  strapdown::Navigation nav{{samples[0].fields[0], samples[0].fields[1], samples[0].fields[2]},
                            {samples[0].fields[3], samples[0].fields[4], samples[0].fields[5]},
                            quaternion_of(samples[0])};
  strapdown::Previous previous;
  for (const Sample& sample : samples) {
    if (sample.channel == ConingSimulator::imu) {
      strapdown::Increment increment;
      increment.dt = seconds(sample.t - sample.t0);
      increment.dtheta = {sample.fields[0], sample.fields[1], sample.fields[2]};
      increment.dv = {sample.fields[3], sample.fields[4], sample.fields[5]};
      nav = strapdown::advance(nav, increment, previous);
      previous = strapdown::remember(previous, increment);
    }
  }
  const Sample* last = nullptr;
  for (const Sample& sample : samples)
    if (sample.channel == ConingSimulator::truth) last = &sample;
  REQUIRE(last->t == nanoseconds(2));
  CHECK(strapdown::attitude_minus(quaternion_of(*last), nav.q_nb).norm() < 1e-8);
  CHECK((nav.v_n - Vector3d(last->fields[3], last->fields[4], last->fields[5])).norm() < 1e-6);
  CHECK(strapdown::position_minus(nav.lla, {last->fields[0], last->fields[1], last->fields[2]}).norm() < 1e-6);
  // It shook: the velocity was another in between.
  CHECK(std::abs(samples[0].fields[3]) > 0.01);
}

TEST_CASE("coning: samples of a thousand cycles are refused", "[coning]") {
  CHECK_THROWS_AS(bound({{"frequency", 1e4}, {"interval", 1}}), ComponentError);
}

TEST_CASE("coning: a damaged memory counts no sample that the run does not have", "[coning]") {
  const auto source =
      bound({{"half_angle", "1 deg"}, {"frequency", "1 Hz"}, {"duration", "1 s"}, {"interval", "0.1 s"}});
  const binnacle::testing::SourceCaller caller(*source);
  for (const std::int64_t damaged : {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1'000'000'000},
                                     std::numeric_limits<std::int64_t>::max()}) {
    auto memory = caller.fresh_memory(1);
    std::memcpy(memory.data(), &damaged, sizeof damaged);  // the first member: the next sample
    for (auto next = caller.next(memory.data()); next.status != SourceStatus::end; next = caller.next(memory.data())) {
      INFO(damaged << ": " << next.damage);
      REQUIRE(next.damage.empty());
      REQUIRE(next.sample.channel == ConingSimulator::truth);
    }
  }
}

}  // namespace coning_simulator_test
