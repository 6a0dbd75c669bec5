// SPDX-License-Identifier: Apache-2.0
// The walk simulator: velocity, acceleration and turn rate against differences, increments against a mechanization, stances.
#include "../../plugins/walk_simulator/simulator.hpp"
#include "../../plugins/walk_simulator/walk.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "catch.hpp"
#include "simulation.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"

namespace walk_simulator_test {

using namespace binnacle;
using namespace binnacle::walk_simulator;
using Eigen::Vector3d;
using simulation::Json;

namespace {

constexpr double degree = std::numbers::pi / 180;
const Vector3d stockholm(59.35 * degree, 18.07 * degree, 30);
const Gait gait{1.4, 1.1, 0.66, 0.12, 0.03, 60 * degree, 25 * degree};
const std::vector<Leg> around{
    {0, 2, 0, 0}, {5, 0, 90 * degree, 0}, {4, 0, 0, 0.7}, {0, 1, 0, 0}, {3, 0, -30 * degree, 0}};

Vector3d metres(const Vector3d& from, const Vector3d& to) { return strapdown::position_minus(to, from); }

const Json config = {{"start", {{"lat", "59.35 deg"}, {"lon", "18.07 deg"}, {"height", "30 m"}, {"heading", "20 deg"}}},
                     {"legs",
                      {{{"do", "stand"}, {"duration", "2 s"}},
                       {{"do", "walk"}, {"strides", 20}, {"turn", "90 deg"}, {"climb", "3 m"}},
                       {{"do", "stand"}, {"duration", "1 s"}}}},
                     {"repeat", 3}};

Json with(const Json& more) {
  Json all = config;
  all.update(more);
  return all;
}

}  // namespace

TEST_CASE(
    "walk simulator: velocity, acceleration and turn rate are the derivatives of position, velocity and attitude") {
  const Walk walk(stockholm, 0.3, gait, around);
  constexpr double h = 1e-4;
  double fastest = 0, hardest = 0;
  for (double t = 2.0 + h; t < walk.duration() - 2 * h; t += 0.00731) {
    const auto before = walk.motion(t - h), now = walk.motion(t), after = walk.motion(t + h);
    INFO("at " << t << " s");
    // Digits of a latitude are 1.4e-9 m; h² times the third derivative is 1e-4 m/s at the sharpest.
    CHECK((metres(before.lla, after.lla) / (2 * h) - now.v_n).norm() < 2e-4);
    CHECK(((after.v_n - before.v_n) / (2 * h) - now.dv_n).norm() < 1e-3);
    CHECK(((after.roll_pitch_yaw - before.roll_pitch_yaw) / (2 * h) - now.euler_rates).norm() < 2e-4);
    fastest = std::max(fastest, now.v_n.norm());
    hardest = std::max(hardest, now.dv_n.norm());
  }
  // What feet do: 4 m/s, and tens of m/s².
  CHECK((fastest > 3.5 && fastest < 4.5));
  CHECK((hardest > 15 && hardest < 40));
}

TEST_CASE("walk simulator: in a stance the foot does not move, and the sensor shows gravity and the earth's rate") {
  const Walk walk(stockholm, 0.3, gait, around);
  for (const double t : {0.5, 1.9, 2.0 + 0.66, 2.0 + 1.0, 2.0 + 3 * 1.1 + 0.9}) {
    INFO(t);
    REQUIRE(walk.is_standing(t));
    const auto now = walk.motion(t);
    CHECK(now.v_n.isZero(0));
    CHECK(now.dv_n.isZero(0));
    CHECK(now.euler_rates.isZero(0));
    const auto sensed = walk.increments(t, t + 0.01);
    if (!walk.is_standing(t + 0.01)) continue;
    CHECK(std::abs(sensed.f_b.norm() / 0.01 - strapdown::gravity(now.lla[0], now.lla[2]).down) < 1e-9);
    CHECK(std::abs(sensed.omega_ib_b.norm() / 0.01 - 7.292115e-5) < 1e-12);
    CHECK(sensed.f_b[2] < -0.09);
  }
  REQUIRE(!walk.is_standing(2.3));
}

TEST_CASE("walk simulator: toes down early and up late, to the right, and up the stairs") {
  const Walk walk(stockholm, 0, gait, {{2, 0, 0, 0.4}});
  // Of one bump there is an eighth left where the other is largest.
  CHECK(std::abs(walk.motion(0.66 / 3).roll_pitch_yaw[1] + (60 - 25.0 / 8) * degree) < 1e-12);
  CHECK(std::abs(walk.motion(0.66 * 2 / 3).roll_pitch_yaw[1] - (25 - 60.0 / 8) * degree) < 1e-12);
  const Vector3d middle = metres(stockholm, walk.motion(0.33).lla), end = metres(stockholm, walk.motion(2.2).lla);
  CHECK((middle - Vector3d(0.7, 0.03, -0.22)).norm() < 1e-6);
  CHECK((end - Vector3d(2.8, 0, -0.4)).norm() < 1e-5);
  // A quarter turn to the right in one stride: along the chord.
  const Walk turning(stockholm, 0, gait, {{1, 0, 90 * degree, 0}});
  const auto turned = turning.motion(1.1);
  CHECK(std::abs(turned.roll_pitch_yaw[2] - 90 * degree) < 1e-12);
  CHECK((metres(stockholm, turned.lla) - Vector3d(1.4, 1.4, 0) / std::sqrt(2)).norm() < 1e-5);
}

TEST_CASE("walk simulator: free of errors, a mechanization of the increments reproduces the truth") {
  // Twice the rate, a quarter of the error: what is left is the mechanization's.
  std::vector<double> worst;
  for (const double rate : {500.0, 1000.0}) {
    simulation::Simulation<WalkSimulator> walk(with({{"perfect", true}, {"imu_rate", rate}, {"truth_rate", 20}}));
    strapdown::Navigation nav;
    strapdown::Previous previous;
    std::optional<simulation::Emitted> truth;
    double position = 0, velocity = 0, attitude = 0;
    while (const auto sample = walk.next()) {
      if (sample->channel == WalkSimulator::initial) {
        nav = {sample->triple(0), sample->triple(3), sample->attitude(6)};
      } else if (sample->channel == WalkSimulator::truth) {
        truth = sample;
      } else {
        const strapdown::Increment increment{seconds(sample->t - sample->t0), sample->triple(0), sample->triple(3)};
        nav = strapdown::advance(nav, increment, previous);
        previous = strapdown::remember(previous, increment);
        if (!truth || truth->t != sample->t) continue;
        position = std::max(position, metres(nav.lla, truth->triple(0)).norm());
        velocity = std::max(velocity, (truth->triple(3) - nav.v_n).norm());
        attitude = std::max(attitude, strapdown::attitude_minus(truth->attitude(6), nav.q_nb).norm());
      }
    }
    INFO(rate << " Hz: " << position << " m, " << velocity << " m/s, " << attitude << " rad");
    CHECK(position < 0.01);
    CHECK(velocity < 1e-3);
    CHECK(attitude < 1e-5);
    worst.push_back(velocity);
  }
  CHECK(worst[1] < 0.5 * worst[0]);
}

TEST_CASE("walk simulator: rates are increments over their interval, truth has its stance, and refusals") {
  simulation::Simulation<WalkSimulator> increments(with({{"perfect", true}})),
      rates(with({{"perfect", true}, {"imu_kind", "rate"}}));
  const auto sums = increments.of(WalkSimulator::imu), means = rates.of(WalkSimulator::imu);
  REQUIRE(sums.size() == means.size());
  for (std::size_t i = 0; i < sums.size(); i += 97)
    for (std::size_t k = 0; k < 6; ++k)
      CHECK(std::abs(sums[i].fields[k] / seconds(sums[i].t - sums[i].t0) - means[i].fields[k]) < 1e-9);
  increments.restart(1);
  double standing = 0, samples = 0;
  for (const auto& truth : increments.of(WalkSimulator::truth)) {
    standing += truth.fields[15];
    samples += 1;
  }
  // 3 s of each 25 s it stands, and 40 % of the rest.
  CHECK(std::abs(standing / samples - (3 + 0.4 * 22) / 25) < 0.02);

  const auto refusal = [](const Json& leg) {
    try {
      simulation::Simulation<WalkSimulator> walk(with({{"legs", {leg}}}));
    } catch (const ComponentError& error) {
      return error.pointer() + ": " + error.what();
    }
    return std::string();
  };
  CHECK(refusal({{"do", "stand"}}) == "/legs/0: 'stand' needs 'duration'");
  CHECK(refusal({{"do", "walk"}, {"strides", 2}, {"duration", "1 s"}}) ==
        "/legs/0/duration: 'walk' does not take 'duration'");
}

}  // namespace walk_simulator_test
