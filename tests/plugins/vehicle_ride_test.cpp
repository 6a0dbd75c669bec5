// SPDX-License-Identifier: Apache-2.0
// The vehicle simulator's ride and body: what the sensor feels is what the truth gives, and nothing changes unasked.
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

#include "catch.hpp"
#include "simulation.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"
#include "vehicle_simulator/simulator.hpp"
#include "vehicle_simulator/spline_noise.hpp"

namespace vehicle_ride_test {

using namespace binnacle;
using namespace binnacle::simulation;
using namespace binnacle::vehicle_simulator;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

using Drive = Simulation<VehicleSimulator>;

// Fields of truth.
constexpr std::size_t lla = 0, v_n = 3, angles = 6, mount = 21, speed = 24, standing = 25;

Json quiet_drive() {
  return {{"start", {{"lat", "36 deg"}, {"lon", "127 deg"}, {"height", 60}, {"heading", "30 deg"}}},
          {"segments", Json::parse(R"([{"do": "still", "duration": 30},
              {"do": "accelerate", "to": 15, "duration": 12}, {"do": "turn", "angle": "80 deg", "duration": 20},
              {"do": "climb", "height": 8, "duration": 25}, {"do": "turn", "angle": "-110 deg", "duration": 18},
              {"do": "accelerate", "to": 0, "duration": 14}, {"do": "still", "duration": 40}])")},
          {"roll_gradient", "4 deg/g"},
          {"imu_rate", 200},
          {"truth_rate", 10},
          {"gnss_rate", 0},
          {"perfect", true}};
}

Json lively() {
  Json config = quiet_drive();
  config["ride"] = {{"slip", 0.003},   {"sway", 0.03}, {"heave", 0.05},
                    {"rocking", 0.03}, {"roll", 2e-3}, {"pitch", 2e-3}};
  config["boarding"] = {{"every", 8}, {"heave", 5e-3}, {"roll", 3e-3}, {"pitch", 2e-3}};
  config["lever_arm"] = {1.2, -0.4, -0.9};
  config["mounting"] = {{"yaw", "35 deg"}, {"roll", "-20 deg"}, {"misalignment", {2e-3, -10.7e-3, 1e-3}}};
  return config;
}

struct Worst {
  double position = 0, velocity = 0, attitude = 0;
};

/// A mechanization of the increments against the truth.
Worst mechanized(const Json& config) {
  Drive drive(config);
  strapdown::Navigation nav;
  strapdown::Previous previous;
  Worst worst;
  std::optional<Emitted> truth;
  while (const auto sample = drive.next()) {
    if (sample->channel == VehicleSimulator::initial)
      nav = {sample->triple(lla), sample->triple(v_n), strapdown::quaternion_from_euler(sample->triple(angles))};
    if (sample->channel == VehicleSimulator::truth) truth = sample;
    if (sample->channel != VehicleSimulator::imu) continue;
    const strapdown::Increment increment{seconds(sample->t - sample->t0), sample->triple(0), sample->triple(3)};
    nav = strapdown::advance(nav, increment, previous);
    previous = strapdown::remember(previous, increment);
    if (!truth || truth->t != sample->t) continue;
    const auto q = strapdown::quaternion_from_euler(truth->triple(angles));
    worst.position = std::max(worst.position, strapdown::position_minus(truth->triple(lla), nav.lla).norm());
    worst.velocity = std::max(worst.velocity, (truth->triple(v_n) - nav.v_n).norm());
    worst.attitude = std::max(worst.attitude, strapdown::attitude_minus(q, nav.q_nb).norm());
  }
  return worst;
}

/// Velocity in vehicle axes: M exp… undone, from the truth alone.
Vector3d vehicle_velocity(const Emitted& truth, const Matrix3d& nominal) {
  const Matrix3d C_nb = strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(truth.triple(angles)));
  const Matrix3d E = strapdown::dcm_from_quaternion(strapdown::quaternion_exp(truth.triple(mount)));
  return E * nominal * C_nb.transpose() * truth.triple(v_n);
}

}  // namespace

TEST_CASE("ride: free of errors, a mechanization of the increments reproduces the truth of a lively drive") {
  const Worst plain = mechanized(quiet_drive()), worst = mechanized(lively());
  INFO(worst.position << " m, " << worst.velocity << " m/s, " << worst.attitude << " rad; on its path "
                      << plain.position << " m");
  // A mechanization of 200 Hz is in doubt by this much where the body shakes; a wrong sign of a term is far outside.
  REQUIRE(worst.position < 0.02);
  REQUIRE(worst.velocity < 5e-4);
  REQUIRE(worst.attitude < 1e-6);
}

TEST_CASE("ride: the path's point slides, heaves and rolls as asked for, and the truth says how the IMU is mounted") {
  Json config = quiet_drive();
  config["segments"] =
      Json::parse(R"([{"do": "accelerate", "to": 15, "duration": 12}, {"do": "straight", "duration": 400},
                                       {"do": "turn", "angle": "360 deg", "duration": 40}])");
  config["ride"] = {{"slip", 0.003}, {"sway", 0.03}, {"heave", 0.05}, {"roll", 2e-3}, {"pitch", 2e-3}};
  config["mounting"] = {{"misalignment", {0, -10.7e-3, 1e-3}}};
  config["imu_rate"] = 1;
  config["roll_gradient"] = 0;
  double y2 = 0, z2 = 0, roll2 = 0, pitch2 = 0, slide = 0;
  int straight = 0, turning = 0;
  for (const Emitted& truth : Drive(config).of(VehicleSimulator::truth)) {
    const double t = seconds(truth.t);
    REQUIRE((truth.triple(mount) - Vector3d(0, -10.7e-3, 1e-3)).norm() < 1e-15);
    REQUIRE(truth.fields[standing] == (truth.fields[speed] == 0 ? 1 : 0));
    const Vector3d v = vehicle_velocity(truth, Matrix3d::Identity());
    const Matrix3d C_nb = strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(truth.triple(angles)));
    const Matrix3d C_nv = C_nb * strapdown::dcm_from_quaternion(strapdown::quaternion_exp(-truth.triple(mount)));
    const Vector3d lean = strapdown::euler_from_quaternion(strapdown::quaternion_from_dcm(C_nv));
    if (t > 15 && t < 410) {
      ++straight;
      y2 += v[1] * v[1], z2 += truth.fields[v_n + 2] * truth.fields[v_n + 2];
      roll2 += lean[0] * lean[0], pitch2 += lean[1] * lean[1];
    } else if (t > 420 && t < 445) {
      ++turning;
      slide += v[1];
    }
  }
  const auto rms = [&](double sum) { return std::sqrt(sum / straight); };
  REQUIRE(std::abs(rms(y2) / 0.03 - 1) < 0.15);
  REQUIRE(std::abs(rms(z2) / 0.05 - 1) < 0.15);
  REQUIRE(std::abs(rms(roll2) / 2e-3 - 1) < 0.15);
  REQUIRE(std::abs(rms(pitch2) / 2e-3 - 1) < 0.15);
  // To the right, so it slides to the left by 0.003 times the lateral acceleration times the speed.
  const double acceleration = 15 * 2 * M_PI / 38;
  REQUIRE(std::abs(slide / turning / (-0.003 * acceleration * 15) - 1) < 0.1);
}

TEST_CASE("ride: the rear axle does not slip in a curve, the IMU ahead of it does") {
  Json config = quiet_drive();
  config["lever_arm"] = {2, 0, 0};
  bool has_turned = false;
  for (const Emitted& truth : Drive(config).of(VehicleSimulator::truth)) {
    const double t = seconds(truth.t);
    if (t < 48 || t > 58) continue;
    has_turned = true;
    const double turn_rate = 80 * M_PI / 180 / 18;
    REQUIRE(std::abs(vehicle_velocity(truth, Matrix3d::Identity())[1] - 2 * turn_rate) < 0.02);
  }
  REQUIRE(has_turned);
}

TEST_CASE("ride: nothing changes unasked, and no part changes what another draws") {
  const auto imu = [](const Json& config) {
    std::vector<std::vector<double>> all;
    for (const Emitted& sample : Drive(config, 7).of(VehicleSimulator::imu)) all.push_back(sample.fields);
    return all;
  };
  Json noisy = quiet_drive();
  noisy["perfect"] = false;
  noisy["imu_rate"] = 20;
  Json spelled = noisy;
  spelled["ride"] = {{"slip", 0}, {"heave", 0}, {"half_speed", 7}};
  spelled["boarding"] = {{"every", 5}};
  spelled["mounting"] = {{"misalignment", {0, 0, 0}}};
  const auto before = imu(noisy);
  REQUIRE(imu(spelled) == before);

  Json pitching = noisy, both = noisy;
  pitching["ride"] = {{"pitch", 1e-3}};
  both["ride"] = {{"pitch", 1e-3}, {"heave", 1e-9}};
  both["shaking"] = {{"standing", {{"accel", 1e-12}}}};
  both["boarding"] = {{"every", 5}, {"roll", 1e-12}};
  const auto one = imu(pitching), two = imu(both);
  double most = 0;
  for (std::size_t i = 0; i < one.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k) most = std::max(most, std::abs(one[i][k] - two[i][k]));
  REQUIRE(most < 1e-8);
  REQUIRE(one != before);
}

TEST_CASE("ride: an engine shakes a standing van, the road a driving one, and neither moves it") {
  Json config = quiet_drive();
  config["segments"] = Json::parse(R"([{"do": "still", "duration": 100}, {"do": "accelerate", "to": 20, "duration": 12},
                                       {"do": "straight", "duration": 100}])");
  config["shaking"] = {{"standing", {{"accel", 0.1}, {"rate", 1e-3}}},
                       {"driving", {{"accel", 0.4}, {"rate", 4e-3}}},
                       {"frequency", 15}};
  double still[6] = {}, driving[6] = {}, sum[6] = {};
  int stood = 0, drove = 0;
  for (const Emitted& sample : Drive(config).of(VehicleSimulator::imu)) {
    const double t = seconds(sample.t);
    for (std::size_t k = 0; k < 6; ++k) {
      double x = sample.fields[k] * 200;
      if (k == 5) x += 9.797;  // about gravity
      if (t < 100) still[k] += x * x, sum[k] += sample.fields[k];
      if (t > 115) driving[k] += x * x;
    }
    (t < 100 ? stood : drove) += t < 100 || t > 115 ? 1 : 0;
  }
  for (std::size_t k = 0; k < 6; ++k) {
    const double unit = k < 3 ? 1e-2 : 1;
    // Increments of 5 ms lose some of what is above 15 Hz.
    REQUIRE(std::sqrt(still[k] / stood) / (0.1 * unit) > 0.85);
    REQUIRE(std::sqrt(still[k] / stood) / (0.1 * unit) < 1.1);
    REQUIRE(std::sqrt(driving[k] / drove) / (0.4 * unit) > 0.85);
    REQUIRE(std::sqrt(driving[k] / drove) / (0.4 * unit) < 1.1);
    if (k < 5) REQUIRE(std::abs(sum[k]) < (k < 3 ? 0.01 : 0.02));
  }
}

TEST_CASE("ride: people board in every part of a stop and leave the van as it was") {
  Json config = quiet_drive();
  config["boarding"] = {{"every", 8}, {"duration", 2}, {"heave", 5e-3}, {"roll", 3e-3}};
  config["truth_rate"] = 50;
  int pushes = 0;
  bool was_pushed = false;
  for (const Emitted& truth : Drive(config).of(VehicleSimulator::truth)) {
    if (truth.fields[speed] != 0) REQUIRE(std::abs(truth.fields[angles + 1]) < 0.2);
    const bool is_pushed = truth.fields[speed] == 0 && std::abs(truth.fields[v_n + 2]) > 1e-6;
    pushes += is_pushed && !was_pushed;
    was_pushed = is_pushed;
  }
  // 30 s and 40 s in parts of 8 s; a push goes down and up again, through rest.
  REQUIRE(pushes >= 8);
  REQUIRE(pushes <= 2 * 8);
  config["boarding"]["every"] = 1;
  REQUIRE_THROWS_AS(Drive(config), ComponentError);
}

TEST_CASE("spline noise: derivatives, deviation, independence, and an answer that knows no history") {
  const SplineNoise noise(1.5);
  SplineMemory memory = SplineNoise::start(3, "a"), other = SplineNoise::start(3, "a");
  const double h = 1e-4;
  double squares = 0, products = 0;
  const int count = 20000;
  double before = 0;
  for (int k = 0; k < count; ++k) {
    const double t = k;  // 1 s: farther than a spline is long
    const double now = noise.at(t, memory).first;
    squares += now * now;
    products += now * before;
    before = now;
  }
  REQUIRE(std::abs(std::sqrt(squares / count) - 1) < 0.02);
  REQUIRE(std::abs(products / count) < 0.03);
  for (const double t : {17.3, 0.0, 17.29, 5.5, 1e4, 0.147}) {
    const auto at = noise.at(t, memory);
    const auto fresh = [&] {
      SplineMemory unused = SplineNoise::start(3, "a");
      return noise.at(t, unused);
    }();
    REQUIRE(at.value == fresh.value);
    REQUIRE(at.second == fresh.second);
    const double slope = (noise.at(t + h, other).value - noise.at(t - h, other).value) / (2 * h);
    const double bend = (noise.at(t + h, other).first - noise.at(t - h, other).first) / (2 * h);
    REQUIRE(std::abs(slope - at.first) < 1e-5);
    REQUIRE(std::abs(bend - at.second) < 1e-4);
  }
}

}  // namespace vehicle_ride_test
