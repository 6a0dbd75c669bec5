// SPDX-License-Identifier: Apache-2.0
// Coarse alignment for tests: the transform with its memory, and a vehicle that rests, turns and drives.
#pragma once

#include "binnacle/bind.hpp"
#include "binnacle/testing.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "catch.hpp"
#include "coarse_alignment/coarse_alignment.hpp"
#include "json_members.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::aligner {

using namespace binnacle::json_members;
using binnacle::coarse_alignment::CoarseAlignment;
namespace sd = binnacle::strapdown;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double deg = M_PI / 180;
constexpr double g = 9.80665;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
inline const double omega = sd::wgs84::omega_ie;

inline double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

inline Json defaults(const std::string& heading) {
  return object({{"heading", heading},
                 {"sigma_heading", 1 * deg},
                 {"duration", 2},
                 {"max_specific_force_sd", 0.15},
                 {"max_rate_sd", 0.5 * deg},
                 {"max_rate", 3 * deg},
                 {"max_gravity_error", 0.5},
                 {"max_speed", 0.3},
                 {"min_speed", 3},
                 {"max_turn_rate", 10 * deg},
                 {"slip_lever_arm", 1.5},
                 {"max_coast", 120},
                 {"accelerometer_bias", 0.01 * g},
                 {"gyro_drift", 0.01 * deg},
                 {"gyro_misalignment", 0.005}});
}

struct Output {
  Time t;
  Vector3d values;
  Matrix3d P;
};

struct Outputs {
  std::vector<Output> attitudes, biases;
};

/// The transform with its memory and what it has emitted.
class Aligner {
 public:
  explicit Aligner(const Json& parameters) : transform_(testing::BoundTo(spec_, {parameters}).binding()) {
    memory = binnacle::testing::TransformCaller(transform_, spec_).fresh_memory(1);
  }
  void imu(Time t0, Time t, const Vector3d& w, const Vector3d& f) {
    const double fields[] = {w.x(), w.y(), w.z(), f.x(), f.y(), f.z()};
    SampleView sample;
    sample.t = t;
    sample.t0 = t0;
    sample.fields = fields;
    offer(0, sample);
  }
  void gnss(Time t, double vn, double ve, double lat = unknown, double sd_n = unknown, double sd_e = unknown) {
    const double fields[] = {vn, ve, lat, sd_n, sd_e};
    SampleView sample;
    sample.t = t;
    sample.fields = fields;
    offer(1, sample);
  }
  const CoarseAlignment& transform() const { return transform_; }

  std::vector<std::byte> memory;
  Outputs out;

 private:
  void offer(std::size_t input, const SampleView& sample) {
    const auto made = binnacle::testing::TransformCaller(transform_, spec_).on(input, sample, memory.data());
    REQUIRE(made.damage.empty());
    for (const auto& emitted : made.samples) {
      REQUIRE(emitted.covariance.size() == 9);
      (emitted.channel == 0 ? out.attitudes : out.biases)
          .push_back({emitted.t, Vector3d(emitted.fields.data()), Matrix3d(emitted.covariance.data())});
    }
  }

  const ComponentSpec spec_ = CoarseAlignment::spec();
  CoarseAlignment transform_;
};

/// A vehicle at rest for some time, which then turns and drives ahead; 100 Hz IMU, 2 Hz GNSS.
struct Drive {
  double lat = 43 * deg;
  Vector3d euler = Vector3d::Zero();  // at rest
  double rest = 4;                    // s
  double length = 4;                  // s, in all
  double acceleration = 0;            // along the x axis, after rest, m/s²
  double turn_rate = 0;               // about down, while turn > 0 is left
  double turn = 0;                    // rad
  Vector3d gyro_bias = Vector3d::Zero();
  Vector3d gyro_drift = Vector3d::Zero();  // added after rest
  Vector3d accelerometer_bias = Vector3d::Zero();
  double gyro_noise = 0;  // per sample, rad/s
  double accelerometer_noise = 0;
  double velocity_noise = 0;
  bool has_gnss = true;
  std::uint32_t seed = 1;

  Vector3d euler_at(double t) const {
    const double turning = turn_rate != 0 ? turn / std::abs(turn_rate) : 0;
    return euler + Vector3d(0, 0, turn_rate * std::clamp(t - rest, 0.0, turning));
  }
  double speed_at(double t) const { return acceleration * std::max(0.0, t - rest); }
  Vector3d velocity_at(double t) const {
    const double yaw = euler_at(t).z();
    return speed_at(t) * Vector3d(std::cos(yaw), std::sin(yaw), 0);
  }

  void run(Aligner& aligner, const std::function<void(double)>& after = {}) const {
    std::mt19937 generator(seed);
    std::normal_distribution<double> normal;
    const auto noise = [&](double sigma) -> Vector3d {
      return sigma * Vector3d(normal(generator), normal(generator), normal(generator));
    };
    constexpr double dt = 0.01;
    aligner.imu(no_time, 0, Vector3d::Zero(), Vector3d::Zero());
    for (int k = 1; k * dt <= length + 1e-9; ++k) {
      const double t0 = (k - 1) * dt, t1 = k * dt;
      const Vector4d q0 = sd::quaternion_from_euler(euler_at(t0)), q1 = sd::quaternion_from_euler(euler_at(t1));
      const Matrix3d C = sd::dcm_from_quaternion(q1);
      Vector3d w = sd::quaternion_log(sd::quaternion_product(sd::quaternion_conjugate(q0), q1)) / dt;
      w += C.transpose() * sd::omega_ie_n(lat) + gyro_bias + noise(gyro_noise);
      if (t0 >= rest) w += gyro_drift;
      const Vector3d a = (velocity_at(t1) - velocity_at(t0)) / dt;
      const Vector3d f = C.transpose() * (a - Vector3d(0, 0, g)) + accelerometer_bias + noise(accelerometer_noise);
      aligner.imu(nanoseconds(t0), nanoseconds(t1), w, f);
      if (has_gnss && k % 50 == 0) {
        const Vector3d v = velocity_at(t1) + noise(velocity_noise);
        aligner.gnss(nanoseconds(t1), v.x(), v.y(), lat);
      }
      if (after) after(t1);
    }
  }
};

inline Vector3d error_of(const Output& attitude, const Vector3d& true_euler) {
  return sd::attitude_minus(sd::quaternion_from_euler(true_euler), sd::quaternion_from_euler(attitude.values));
}

inline double nees(const Output& attitude, const Vector3d& true_euler) {
  const Vector3d phi = error_of(attitude, true_euler);
  return phi.dot(attitude.P.ldlt().solve(phi));
}

inline const std::vector<Vector3d> every_quadrant = [] {
  std::vector<Vector3d> attitudes;
  for (double roll : {-150.0, -80.0, -3.0, 2.0, 60.0, 120.0})
    for (double pitch : {-50.0, -2.0, 4.0, 70.0})
      for (double yaw : {-170.0, -100.0, -10.0, 30.0, 95.0, 179.0})
        attitudes.push_back(Vector3d(roll, pitch, yaw) * deg);
  return attitudes;
}();

}  // namespace binnacle::aligner
