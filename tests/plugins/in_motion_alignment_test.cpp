// SPDX-License-Identifier: Apache-2.0
// Alignment in motion: any attitude, any direction, no rest; its covariance; no attitude where motion does not show it.
#include "in_motion_alignment/in_motion_alignment.hpp"

#include "binnacle/bind.hpp"
#include "binnacle/testing.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "catch.hpp"
#include "json_members.hpp"
#include "strapdown/rotation.hpp"

namespace in_motion_alignment_test {

using namespace binnacle;
using namespace binnacle::json_members;
using binnacle::in_motion_alignment::InMotionAlignment;
namespace sd = binnacle::strapdown;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

constexpr double deg = M_PI / 180, g = 9.80665;

Members defaults() {
  return {{"window", 20},          {"every", 1},         {"max_heading_sd", 5 * deg},
          {"max_misfit", 3},       {"velocity_sd", 0.1}, {"accelerometer_bias", 0.02 * g},
          {"gyro_bias", 0.5 * deg}};
}

/// Of a vehicle that drives forward.
Json with_course() {
  auto parameters = defaults();
  parameters.push_back({"course", 3 * deg});
  parameters.push_back({"min_speed", 3});
  return object(std::move(parameters));
}

struct Output {
  Time t;
  Vector3d values;
  Matrix3d P;
};

/// The transform with its memory and what it has emitted.
class Aligner {
 public:
  explicit Aligner(const Json& parameters = object(defaults()))
      : transform_(testing::BoundTo(spec_, {parameters}).binding()) {
    memory = testing::TransformCaller(transform_, spec_).fresh_memory(1);
  }
  void offer(std::size_t input, Time t0, Time t, const std::vector<double>& fields) {
    SampleView sample;
    sample.t = t;
    sample.t0 = t0;
    sample.fields = fields.data();
    const auto made = testing::TransformCaller(transform_, spec_).on(input, sample, memory.data());
    REQUIRE(made.damage.empty());
    for (const auto& emitted : made.samples)
      (emitted.channel == 0 ? attitudes : biases)
          .push_back({emitted.t, Vector3d(emitted.fields.data()), Matrix3d(emitted.covariance.data())});
  }
  std::string waits_for() { return transform_.waits_for(MemoryView(memory.data())); }

  std::vector<std::byte> memory;
  std::vector<Output> attitudes, biases;

 private:
  const ComponentSpec spec_ = InMotionAlignment::spec();
  InMotionAlignment transform_;
};

/// A vehicle that moves from the begin on; 100 Hz IMU, 2 Hz GNSS, on an earth that does not turn.
struct Ride {
  Vector3d mount = Vector3d::Zero();  // Euler angles vehicle to body
  double yaw = 0;                     // at the begin
  double length = 25;                 // s
  std::function<double(double)> turned = [](double t) { return 0.6 * (1 - std::cos(0.4 * t)); };
  std::function<double(double)> speed = [](double t) { return 8 + 3 * std::sin(0.7 * t); };
  Vector3d gyro_bias = Vector3d::Zero(), accelerometer_bias = Vector3d::Zero();
  double velocity_noise = 0;
  double gyro_noise = 0, noisy_until = 0;  // rad/s, of each sample up to then
  std::uint32_t seed = 1;

  Vector4d q(double t) const {
    return sd::quaternion_product(sd::quaternion_from_euler({0.05 * std::sin(t), 0.03 * std::cos(t), yaw + turned(t)}),
                                  sd::quaternion_from_euler(mount));
  }
  Vector3d velocity(double t) const {
    return speed(t) * Vector3d(std::cos(yaw + turned(t)), std::sin(yaw + turned(t)), 0.05);
  }
  Vector3d error(const Output& attitude) const {
    return sd::attitude_minus(q(seconds(attitude.t)), sd::quaternion_from_euler(attitude.values));
  }

  void run(Aligner& aligner) const {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal(0, 1);
    constexpr double dt = 0.01;
    for (int k = 0; k * dt <= length; ++k) {
      const double t0 = (k - 1) * dt, t1 = k * dt;
      const Vector3d w = sd::quaternion_log(sd::quaternion_product(sd::quaternion_conjugate(q(t0)), q(t1))) / dt;
      const Vector3d a = (velocity(t1) - velocity(t0)) / dt;
      const Vector3d f = sd::dcm_from_quaternion(q(0.5 * (t0 + t1))).transpose() * (a - Vector3d(0, 0, g));
      Vector3d rate = w + gyro_bias;
      const Vector3d force = f + accelerometer_bias;
      for (int i = 0; i < 3 && t1 < noisy_until; ++i) rate[i] += gyro_noise * normal(generator);
      aligner.offer(0, k == 0 ? no_time : nanoseconds(t0), nanoseconds(t1),
                    {rate.x(), rate.y(), rate.z(), force.x(), force.y(), force.z()});
      if (k % 50 != 0) continue;
      Vector3d v = velocity(t1);
      for (int i = 0; i < 3; ++i) v[i] += velocity_noise * normal(generator);
      const double none = std::nan("");
      aligner.offer(1, no_time, nanoseconds(t1), {v.x(), v.y(), v.z(), none, none, none});
    }
  }
};

}  // namespace

TEST_CASE("in motion: any heading and any mounting") {
  for (int i = 0; i < 24; ++i) {
    Ride ride;
    ride.yaw = 15 * i * deg;
    ride.mount = Vector3d(37 * i, 11 * i % 80, -53 * i) * deg;
    Aligner aligner;
    ride.run(aligner);
    REQUIRE_FALSE(aligner.attitudes.empty());
    CHECK(ride.error(aligner.attitudes.back()).norm() < 0.02 * deg);
  }
}

TEST_CASE("in motion: a vehicle that reverses is not turned round") {
  Ride ride;
  ride.yaw = 1;
  ride.speed = [](double t) { return -4 - 2 * std::sin(0.7 * t); };
  Aligner aligner;
  ride.run(aligner);
  REQUIRE_FALSE(aligner.attitudes.empty());
  CHECK(ride.error(aligner.attitudes.back()).norm() < 0.02 * deg);
}

TEST_CASE("in motion: biases of the sensors are found") {
  Ride ride;
  ride.length = 60;
  ride.gyro_bias = Vector3d(0.4, -0.3, 0.5) * deg;
  Aligner aligner;
  ride.run(aligner);
  REQUIRE_FALSE(aligner.biases.empty());
  CHECK((aligner.biases.back().values - ride.gyro_bias).norm() < 0.05 * deg);
  CHECK(ride.error(aligner.attitudes.back()).norm() < 0.3 * deg);
}

TEST_CASE("in motion: errors are as large as the covariance says") {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal(0, 1);
  const auto draw = [&](double sigma) -> Vector3d {
    return sigma * Vector3d(normal(generator), normal(generator), normal(generator));
  };
  constexpr int runs = 200;
  double nees = 0, nees_bias = 0;
  for (int i = 0; i < runs; ++i) {
    Ride ride;
    ride.seed = static_cast<std::uint32_t>(i + 1);
    ride.yaw = 0.1 * i;
    ride.gyro_bias = draw(0.5 * deg);
    ride.accelerometer_bias = draw(0.02 * g);
    ride.velocity_noise = 0.1;
    Aligner aligner;
    ride.run(aligner);
    REQUIRE_FALSE(aligner.attitudes.empty());
    const auto& last = aligner.attitudes.back();
    const Vector3d phi = ride.error(last);
    nees += phi.dot(last.P.ldlt().solve(phi)) / runs;
    const Vector3d bias = ride.gyro_bias - aligner.biases.back().values;
    nees_bias += bias.dot(aligner.biases.back().P.ldlt().solve(bias)) / runs;
  }
  INFO("NEES " << nees << " and " << nees_bias);
  // χ² of 600 degrees of freedom, 99 %; a misfit above 1 by chance widens P, and takes up to a tenth off the mean.
  const double band = 2.576 * std::sqrt(2.0 * 3.0 / runs);
  CHECK(nees > 2.7 - band);
  CHECK(nees < 3 + band);
  CHECK(nees_bias > 2.7 - band);
  CHECK(nees_bias < 3 + band);
}

TEST_CASE("in motion: without acceleration there is no heading, and it says so") {
  Ride ride;
  ride.speed = [](double) { return 20.0; };
  ride.turned = [](double) { return 0.0; };
  ride.velocity_noise = 0.1;
  Aligner aligner;
  ride.run(aligner);
  CHECK(aligner.attitudes.empty());
  CHECK(aligner.waits_for().find("did not accelerate or turn enough") != std::string::npos);
}

TEST_CASE("in motion: a hole in the IMU begins the window anew") {
  Ride ride;
  ride.length = 12;
  Aligner aligner;
  ride.run(aligner);
  const auto before = aligner.attitudes.size();
  CHECK(before > 0);
  aligner.offer(0, nanoseconds(13.0), nanoseconds(13.01), {0, 0, 0, 0, 0, -g});
  aligner.offer(1, no_time, nanoseconds(13.01), {1, 1, 0, std::nan(""), std::nan(""), std::nan("")});
  CHECK(aligner.attitudes.size() == before);
}

TEST_CASE("in motion: with the course an attitude comes from the third velocity on") {
  for (int i = 0; i < 24; ++i) {
    Ride ride;
    ride.yaw = 15 * i * deg;
    ride.length = 4;
    ride.seed = static_cast<std::uint32_t>(i + 1);
    ride.velocity_noise = 0.1;
    Aligner aligner(with_course());
    ride.run(aligner);
    REQUIRE_FALSE(aligner.attitudes.empty());
    CHECK(seconds(aligner.attitudes.front().t) == 1.0);
    for (const auto& attitude : aligner.attitudes) {
      const Vector3d phi = ride.error(attitude);
      CHECK(phi.norm() < 6 * deg);
      CHECK(phi.dot(attitude.P.ldlt().solve(phi)) < 16.3);  // χ² of 3 degrees of freedom, 99.9 %
    }
  }
}

TEST_CASE("in motion: without speed there is no course, and a whole window needs none") {
  Ride slow;
  slow.length = 4;
  slow.speed = [](double) { return 2.0; };
  Aligner waiting(with_course());
  slow.run(waiting);
  CHECK(waiting.attitudes.empty());

  Ride reversing;
  reversing.speed = [](double t) { return -4 - 2 * std::sin(0.7 * t); };
  Aligner aligner(with_course());
  reversing.run(aligner);
  REQUIRE(aligner.attitudes.size() > 10);
  CHECK(reversing.error(aligner.attitudes.back()).norm() < 0.02 * deg);
}

TEST_CASE("in motion: of a sensor that is spoilt no attitude comes, and with the course a coarse one") {
  const auto worst = [](const Json& parameters, std::size_t& count) {
    double error = 0;
    for (std::uint32_t seed = 1; seed <= 10; ++seed) {
      Ride ride;
      ride.length = 40;
      ride.gyro_noise = 100 * deg;
      ride.noisy_until = 20;
      ride.velocity_noise = 0.1;
      ride.seed = seed;
      Aligner aligner(parameters);
      ride.run(aligner);
      count += aligner.attitudes.size();
      for (const auto& attitude : aligner.attitudes) error = std::max(error, ride.error(attitude).norm());
    }
    return error;
  };
  std::size_t alone = 0, by_course = 0;
  CHECK(worst(object(defaults()), alone) < 30 * deg);
  CHECK(worst(with_course(), by_course) < 30 * deg);
  CHECK(alone > 0);
  CHECK(by_course > 2 * alone);
}

}  // namespace in_motion_alignment_test
