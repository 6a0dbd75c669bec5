// SPDX-License-Identifier: Apache-2.0
// Coarse alignment: signs in every quadrant, honest covariances, no attitude without rest, recorded drives.
#include "../recorded_data.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"

#include <Eigen/Dense>

#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "coarse_alignment/coarse_alignment.hpp"
#include "coarse_alignment/rest_window.hpp"
#include "csv/csv_source.hpp"
#include "parameter_values.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace {

using namespace binnacle;
using namespace binnacle::parameter_values;
using binnacle::coarse_alignment::CoarseAlignment;
namespace sd = binnacle::strapdown;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double deg = M_PI / 180;
constexpr double g = 9.80665;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
const double omega = sd::wgs84::omega_ie;

double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

ParameterValue defaults(const std::string& heading) {
  return object({{"heading", text(heading)},
                 {"sigma_heading", number(1 * deg)},
                 {"duration", instant(2)},
                 {"max_specific_force_sd", number(0.15)},
                 {"max_rate_sd", number(0.5 * deg)},
                 {"max_rate", number(3 * deg)},
                 {"max_gravity_error", number(0.5)},
                 {"max_speed", number(0.3)},
                 {"min_speed", number(3)},
                 {"max_turn_rate", number(10 * deg)},
                 {"slip_lever_arm", number(1.5)},
                 {"max_coast", instant(120)},
                 {"accelerometer_bias", number(0.01 * g)},
                 {"gyro_drift", number(0.01 * deg)},
                 {"gyro_misalignment", number(0.005)}});
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
  explicit Aligner(const ParameterValue& parameters) : transform_(bind_as<CoarseAlignment>(parameters)) {
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

Vector3d error_of(const Output& attitude, const Vector3d& true_euler) {
  return sd::attitude_minus(sd::quaternion_from_euler(true_euler), sd::quaternion_from_euler(attitude.values));
}

double nees(const Output& attitude, const Vector3d& true_euler) {
  const Vector3d phi = error_of(attitude, true_euler);
  return phi.dot(attitude.P.ldlt().solve(phi));
}

const std::vector<Vector3d> every_quadrant = [] {
  std::vector<Vector3d> attitudes;
  for (double roll : {-150.0, -80.0, -3.0, 2.0, 60.0, 120.0})
    for (double pitch : {-50.0, -2.0, 4.0, 70.0})
      for (double yaw : {-170.0, -100.0, -10.0, 30.0, 95.0, 179.0})
        attitudes.push_back(Vector3d(roll, pitch, yaw) * deg);
  return attitudes;
}();

}  // namespace

TEST_CASE("alignment: heading given, roll and pitch in every quadrant") {
  for (const auto& euler : every_quadrant) {
    Aligner aligner(with(defaults("given"), "yaw", number(euler.z())));
    Drive drive;
    drive.euler = euler;
    drive.run(aligner);
    REQUIRE(aligner.out.attitudes.size() == 1);
    const auto& attitude = aligner.out.attitudes[0];
    REQUIRE(error_of(attitude, euler).norm() < 1e-9);
    REQUIRE((attitude.values - euler).cwiseAbs().maxCoeff() < 1e-9);
    REQUIRE(attitude.t == nanoseconds(2.25));  // duration and an eighth
  }
}

TEST_CASE("alignment: the signs, spelled out") {
  const auto align = [](const Vector3d& f) {
    Aligner aligner(with(defaults("given"), "yaw", number(0)));
    for (int k = 0; k <= 300; ++k)
      aligner.imu(k ? nanoseconds(k * 0.01 - 0.01) : no_time, nanoseconds(k * 0.01), Vector3d::Zero(), f);
    return aligner.out.attitudes.at(0).values;
  };
  const double s = std::sin(10 * deg), c = std::cos(10 * deg);
  // Nose up: the forward accelerometer is pushed forward.
  REQUIRE((align({g * s, 0, -g * c}) - Vector3d(0, 10 * deg, 0)).norm() < 1e-12);
  // Right side down: the right accelerometer is pushed left.
  REQUIRE((align({0, -g * s, -g * c}) - Vector3d(10 * deg, 0, 0)).norm() < 1e-12);
}

TEST_CASE("alignment: heading from the course, after a turn, in every quadrant") {
  for (const auto& euler : every_quadrant) {
    if (std::abs(euler.x()) > 1.5) continue;
    for (double turn_rate : {30 * deg, -30 * deg}) {
      Aligner aligner(defaults("course"));
      Drive drive;
      drive.euler = euler;
      drive.acceleration = 1;
      drive.turn_rate = turn_rate;
      drive.turn = 100 * deg;
      drive.length = 10;
      drive.run(aligner);
      REQUIRE(aligner.out.attitudes.size() == 1);
      const auto& attitude = aligner.out.attitudes[0];
      // 3 m/s at 7 s, while still turning too fast; the turn ends at 7.33 s
      REQUIRE(attitude.t == nanoseconds(7.5));
      REQUIRE(error_of(attitude, drive.euler_at(7.5)).norm() < 5e-4);  // the earth rate that turned with the body
    }
  }
}

TEST_CASE("alignment: gyrocompassing in every quadrant, north and south") {
  for (double lat : {45 * deg, -35 * deg, 0.0}) {
    for (const auto& euler : every_quadrant) {
      auto parameters = with(defaults("gyrocompass"), "gyro_bias", number(1e-8));
      parameters = with(parameters, "accelerometer_bias", number(1e-4));
      Aligner aligner(with(parameters, "latitude", number(lat)));
      REQUIRE(aligner.transform().declaration().channels.size() == 1);
      Drive drive;
      drive.lat = lat;
      drive.euler = euler;
      drive.run(aligner);
      REQUIRE(aligner.out.attitudes.size() == 1);
      REQUIRE(error_of(aligner.out.attitudes[0], euler).norm() < 1e-8);
      REQUIRE(aligner.out.biases.empty());
    }
  }
}

TEST_CASE("alignment: gyrocompassing takes the latitude from GNSS, and waits for it") {
  const auto parameters = with(defaults("gyrocompass"), "gyro_bias", number(1e-7));
  Drive drive;
  Aligner with_gnss(parameters);
  drive.run(with_gnss);
  REQUIRE(with_gnss.out.attitudes.size() == 1);
  Aligner without(parameters);
  drive.has_gnss = false;
  drive.run(without);
  REQUIRE(without.out.attitudes.empty());
}

TEST_CASE("alignment: gyrocompassing refuses gyros that do not see the earth turn") {
  auto parameters = with(defaults("gyrocompass"), "latitude", number(43 * deg));
  Drive drive;
  Aligner coarse(with(parameters, "gyro_bias", number(20 * deg / 3600)));
  drive.run(coarse);
  REQUIRE(coarse.out.attitudes.empty());
  // Promised 0.1 deg/h, but 10 deg/h off: the horizontal rate is not the earth's.
  drive.gyro_bias = Vector3d(10, 0, 0) * deg / 3600;
  Aligner liar(with(parameters, "gyro_bias", number(0.1 * deg / 3600)));
  drive.run(liar);
  REQUIRE(liar.out.attitudes.empty());
}

TEST_CASE("alignment: the covariance, written out") {
  auto parameters = with(defaults("given"), "yaw", number(120 * deg));
  Drive drive;
  drive.euler = Vector3d(20, 30, 120) * deg;
  Aligner aligner(parameters);
  drive.run(aligner);
  const Matrix3d P = aligner.out.attitudes.at(0).P;
  REQUIRE((P - P.transpose()).norm() == 0);
  REQUIRE(std::abs(std::sqrt(P(0, 0)) - 0.01) < 1e-9);  // 10 mg / g
  REQUIRE(std::abs(P(0, 1)) < 1e-15);
  // The yaw angle is off by 1 deg whatever the tilt is.
  const Vector3d yaw_row(std::tan(30 * deg) * std::cos(120 * deg), std::tan(30 * deg) * std::sin(120 * deg), 1);
  REQUIRE(std::abs(std::sqrt(yaw_row.dot(P * yaw_row)) - 1 * deg) < 1e-9);
}

TEST_CASE("alignment: Monte Carlo, errors are as large as the covariances say") {
  constexpr int runs = 300;
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sigma) -> Vector3d {
    return sigma * Vector3d(normal(generator), normal(generator), normal(generator));
  };
  const auto check = [&](const char* name, const std::function<double(int)>& one_run, double lowest = 3) {
    double sum = 0;
    for (int i = 0; i < runs; ++i) sum += one_run(i);
    const double mean = sum / runs;
    std::cout << "coarse_alignment: mean NEES of " << runs << " runs, " << name << ": " << mean << " (3 expected)\n";
    const double band = 2.576 * std::sqrt(2.0 * 3.0 / runs);
    REQUIRE(mean > lowest - band);
    REQUIRE(mean < 3 + band);
  };
  check("given", [&](int i) {
    Drive drive;
    drive.seed = static_cast<std::uint32_t>(i + 1);
    drive.length = 2.5;
    drive.has_gnss = false;
    drive.euler = Vector3d(10, -40, 7 * i % 360 - 180) * deg;
    drive.accelerometer_bias = draw(0.01 * g);
    drive.accelerometer_noise = 0.01;
    Aligner aligner(with(defaults("given"), "yaw", number(drive.euler.z() + 1 * deg * normal(generator))));
    drive.run(aligner);
    return nees(aligner.out.attitudes.at(0), drive.euler);
  });
  check("course", [&](int i) {
    Drive drive;
    drive.seed = static_cast<std::uint32_t>(i + 1);
    drive.rest = 3;
    drive.length = 14;
    drive.acceleration = 0.3;
    drive.euler = Vector3d(10, -20, 7 * i % 360 - 180) * deg;
    drive.accelerometer_bias = draw(0.01 * g);
    drive.gyro_bias = draw(0.5 * deg);
    drive.gyro_drift = draw(0.05 * deg);
    drive.gyro_noise = 0.1 * deg;
    drive.velocity_noise = 0.05;
    auto parameters = with(with(defaults("course"), "sigma_heading", number(0)), "velocity_sd", number(0.05));
    Aligner aligner(with(parameters, "gyro_drift", number(0.05 * deg)));
    drive.run(aligner);
    const auto& attitude = aligner.out.attitudes.at(0);
    return nees(attitude, drive.euler_at(seconds(attitude.t)));
  });
  check("gyrocompass", [&](int i) {
    Drive drive;
    drive.seed = static_cast<std::uint32_t>(i + 1);
    drive.length = 2.5;
    drive.has_gnss = false;
    drive.euler = Vector3d(-70, 50, 7 * i % 360 - 180) * deg;
    drive.accelerometer_bias = draw(0.001 * g);
    drive.gyro_bias = draw(0.01 * deg / 3600);
    auto parameters =
        with(with(defaults("gyrocompass"), "latitude", number(drive.lat)), "gyro_bias", number(0.01 * deg / 3600));
    Aligner aligner(with(parameters, "accelerometer_bias", number(0.001 * g)));
    drive.run(aligner);
    return nees(aligner.out.attitudes.at(0), drive.euler);
  });
  // With noise alone the worst of three axes stands for all: on the safe side.
  check(
      "noise alone",
      [&](int i) {
        Drive drive;
        drive.seed = static_cast<std::uint32_t>(i + 1);
        drive.length = 2.5;
        drive.has_gnss = false;
        drive.accelerometer_noise = 0.1;
        Aligner aligner(
            with(with(defaults("given"), "yaw", number(1 * deg * normal(generator))), "accelerometer_bias", number(0)));
        drive.run(aligner);
        return nees(aligner.out.attitudes.at(0), drive.euler);
      },
      2);
}

TEST_CASE("alignment: nothing while moving") {
  // Quiet as at rest, but the receiver says 10 m/s.
  Aligner cruising(with(defaults("given"), "yaw", number(0)));
  for (int k = 0; k <= 2000; ++k) {
    cruising.imu(k ? nanoseconds(k * 0.01 - 0.01) : no_time, nanoseconds(k * 0.01), Vector3d::Zero(), {0, 0, -g});
    if (k % 50 == 0) cruising.gnss(nanoseconds(k * 0.01), 10, 0, 0.7);
  }
  REQUIRE(cruising.out.attitudes.empty());

  // A drive that is recorded from the middle, without rest: no course either.
  for (const char* heading : {"given", "course"}) {
    Aligner moving(with(defaults(heading), "yaw", number(0)));
    Drive drive;
    drive.rest = 0;
    drive.acceleration = 1;
    drive.turn_rate = 20 * deg;
    drive.turn = 20;
    drive.length = 20;
    drive.accelerometer_noise = 0.3;
    drive.run(moving);
    REQUIRE(moving.out.attitudes.empty());
  }
}

TEST_CASE("alignment: each limit of rest alone keeps it from levelling") {
  const auto aligned = [](const Vector3d& w, const Vector3d& f, const Vector3d& dw, const Vector3d& df) {
    Aligner aligner(with(defaults("given"), "yaw", number(0)));
    for (int k = 0; k <= 600; ++k) {
      const double sign = k % 2 ? 1 : -1;
      aligner.imu(k ? nanoseconds(k * 0.01 - 0.01) : no_time, nanoseconds(k * 0.01), w + sign * dw, f + sign * df);
    }
    return aligner.out.attitudes.size() == 1;
  };
  const Vector3d zero = Vector3d::Zero(), down(0, 0, -g);
  REQUIRE(aligned(zero, down, zero, zero));
  REQUIRE(aligned({2.9 * deg, 0, 0}, {0, 0, -g - 0.49}, {0, 0.49 * deg, 0}, {0, 0, 0.14}));
  REQUIRE(!aligned({0, 3.1 * deg, 0}, down, zero, zero));
  REQUIRE(!aligned(zero, {0, 0, -g - 0.51}, zero, zero));
  REQUIRE(!aligned(zero, down, {0, 0.51 * deg, 0}, zero));
  REQUIRE(!aligned(zero, down, zero, {0.16, 0, 0}));
}

TEST_CASE("alignment: the latest quiet block is not in the mean") {
  const binnacle::coarse_alignment::RestLimits limits{8, 0.15, 0.01, 0.05, 0.5};
  binnacle::coarse_alignment::RestWindow window;
  using Event = binnacle::coarse_alignment::RestWindow::Event;
  const auto add = [&](double fx) { return window.add(limits, 1, {0.001, 0, 0}, {fx, 0, -g}); };
  for (int k = 0; k < 8; ++k) REQUIRE(add(0) == Event::none);
  REQUIRE(add(0.1) == Event::at_rest);
  REQUIRE(window.means().specific_force.x() == 0);
  REQUIRE(std::abs(window.means().rate.x() - 0.001) < 1e-15);
  REQUIRE(add(0.1) == Event::at_rest);
  REQUIRE(std::abs(window.means().specific_force.x() - 0.1 / 8) < 1e-15);
  // Seven parts of 0 and one of a: the mean's variance is 7/64 a² / 7, times 7/5 for being estimated from eight parts.
  REQUIRE(std::abs(window.means().specific_force_variance - 0.01 / 64 * 7 / 5) < 1e-12);
  REQUIRE(add(0.3) == Event::none);  // quiet, but at another attitude: a new beginning
  for (int k = 0; k < 7; ++k) REQUIRE(add(0.3) == Event::none);
  REQUIRE(add(0.3) == Event::at_rest);
}

TEST_CASE("alignment: no course from a fix long after the last IMU sample, or before it") {
  for (double t : {3.9, 4.11, 10.0}) {
    Aligner aligner(defaults("course"));
    Drive drive;
    drive.has_gnss = false;
    drive.run(aligner);  // to 4 s
    aligner.gnss(nanoseconds(t), 5, 0);
    REQUIRE(aligner.out.attitudes.empty());
  }
}

TEST_CASE("alignment: a gentle start does not pull the levelling") {
  Aligner aligner(defaults("course"));
  Drive drive;
  drive.rest = 5.1;  // in the middle of a block
  drive.length = 25;
  drive.acceleration = 0.2;  // an apparent pitch of 1.2 deg
  drive.has_gnss = true;
  drive.run(aligner);
  REQUIRE(aligner.out.attitudes.size() == 1);
  REQUIRE(error_of(aligner.out.attitudes[0], drive.euler).norm() < 0.1 * deg);
}

TEST_CASE("alignment: after a gap it starts anew, a short hole and a NaN it bridges") {
  const Vector3d zero = Vector3d::Zero(), down(0, 0, -g);
  const auto run = [&](const std::function<void(Aligner&)>& at_two_seconds, int resumed = 206) {
    Aligner aligner(with(defaults("given"), "yaw", number(0)));
    aligner.imu(no_time, 0, zero, down);
    for (int k = 1; k <= 600; ++k) {
      if (k == 201) at_two_seconds(aligner);
      if (k >= 201 && k < resumed) continue;
      aligner.imu(nanoseconds(k * 0.01 - 0.01), nanoseconds(k * 0.01), zero, down);
    }
    return aligner.out.attitudes.empty() ? -1.0 : seconds(aligner.out.attitudes[0].t);
  };
  REQUIRE(std::abs(run([](Aligner&) {}) - 2.25) < 0.06);
  REQUIRE(std::abs(run([&](Aligner& a) {
                     a.imu(nanoseconds(2.0), nanoseconds(2.01), {unknown, 0, 0}, down);
                   }) -
                   2.25) < 0.06);
  REQUIRE(std::abs(run([&](Aligner& a) { a.imu(no_time, nanoseconds(2.04), zero, down); }) - 4.29) < 0.06);
  REQUIRE(std::abs(run([&](Aligner& a) { a.imu(nanoseconds(2.04), nanoseconds(2.05), zero, down); }) - 2.25) < 0.06);
  REQUIRE(std::abs(run([](Aligner&) {}, 211) - 2.25) < 0.06);
  REQUIRE(std::abs(run([](Aligner&) {}, 212) - 4.37) < 0.06);
}

TEST_CASE("alignment: no course once it has coasted too long") {
  Drive drive;
  drive.acceleration = 0.1;  // 3 m/s after 30 s
  drive.length = 60;
  Aligner steady(defaults("course"));
  drive.run(steady);
  REQUIRE(steady.out.attitudes.size() == 1);
  Aligner hasty(with(defaults("course"), "max_coast", instant(20)));
  drive.run(hasty);
  REQUIRE(hasty.out.attitudes.empty());
}

TEST_CASE("alignment: course uncertainty from reported velocity deviations, turn and slip") {
  const auto heading_sd = [](const ParameterValue& parameters, double sd_n, double sd_e) {
    Aligner aligner(parameters);
    Drive drive;
    drive.has_gnss = false;
    drive.run(aligner);
    aligner.gnss(nanoseconds(4.0), 0, 4, unknown, sd_n, sd_e);  // to the east
    return std::sqrt(aligner.out.attitudes.at(0).P(2, 2));
  };
  const auto parameters = with(defaults("course"), "sigma_heading", number(0));
  REQUIRE(std::abs(heading_sd(parameters, 0.4, 9.0) - 0.1) < 1e-3);
  REQUIRE(std::abs(heading_sd(parameters, unknown, unknown) - 0.05) < 1e-3);
  REQUIRE(std::abs(heading_sd(with(parameters, "velocity_sd", number(0.8)), 0.4, 9.0) - 0.2) < 1e-3);
  REQUIRE(std::abs(heading_sd(with(parameters, "sigma_heading", number(0.3)), unknown, unknown) -
                   std::hypot(0.3, 0.05)) < 1e-3);
}

TEST_CASE("alignment: emits again at the wanted pace, levels again at rest, and coasts in between") {
  Drive drive;
  drive.acceleration = 0.5;
  drive.rest = 6;
  drive.length = 20;
  drive.euler = Vector3d(3, -2, 40) * deg;
  drive.turn_rate = 8 * deg;
  drive.turn = 60 * deg;
  drive.gyro_bias = Vector3d(0.3, -0.2, 0.1) * deg;
  Aligner aligner(with(with(defaults("given"), "yaw", number(40 * deg)), "every", instant(1)));
  drive.run(aligner);
  const auto& attitudes = aligner.out.attitudes;
  REQUIRE(attitudes.size() == 18);
  for (std::size_t i = 0; i < attitudes.size(); ++i) {
    REQUIRE(attitudes[i].t == nanoseconds(2.25 + static_cast<double>(i)));
    REQUIRE(error_of(attitudes[i], drive.euler_at(seconds(attitudes[i].t))).norm() < 2e-3);
    if (i > 4) REQUIRE(attitudes[i].P(0, 0) > attitudes[i - 1].P(0, 0));
  }
  REQUIRE(aligner.out.biases.size() == attitudes.size());
}

TEST_CASE("alignment: the gyro bias at rest, without the earth's rate") {
  Drive drive;
  drive.euler = Vector3d(5, 10, -130) * deg;
  drive.gyro_bias = Vector3d(0.2, -0.3, 0.1) * deg;
  const auto parameters = with(with(defaults("given"), "yaw", number(drive.euler.z())), "gyro_drift", number(0));
  Aligner aligner(parameters);
  const auto& channels = aligner.transform().declaration().channels;
  REQUIRE(channels.size() == 2);
  REQUIRE(channels[0].name.empty());
  REQUIRE(channels[0].covariance.size() == 3);
  REQUIRE(channels[1].name == "gyro_bias");
  drive.run(aligner);
  REQUIRE(aligner.out.biases.size() == 1);
  REQUIRE((aligner.out.biases[0].values - drive.gyro_bias).norm() < 1e-9);
  REQUIRE(aligner.out.biases[0].P(0, 0) < omega * omega * 1e-3);
  drive.has_gnss = false;
  Aligner unlocated(parameters);
  drive.run(unlocated);
  const Vector3d error = unlocated.out.biases.at(0).values - drive.gyro_bias;
  REQUIRE(std::abs(error.norm() - omega) < 1e-9);
  REQUIRE(std::sqrt(unlocated.out.biases[0].P(1, 1)) >= omega);
}

TEST_CASE("alignment: its memory is all that it knows") {
  Drive drive;
  drive.acceleration = 1;
  drive.length = 10;
  drive.accelerometer_noise = 0.02;
  Aligner straight(defaults("course")), copied(defaults("course"));
  drive.run(straight);
  drive.run(copied, [&](double) {
    const std::vector<std::byte> snapshot = copied.memory;  // another place in memory
    copied.memory = snapshot;
  });
  REQUIRE(straight.out.attitudes.size() == 1);
  REQUIRE(straight.out.attitudes[0].values == copied.out.attitudes.at(0).values);
  REQUIRE(straight.memory == copied.memory);
}

TEST_CASE("alignment: refuses what does not go together") {
  const auto fault = [](const ParameterValue& parameters) -> std::string {
    try {
      CoarseAlignment transform(bind_as<CoarseAlignment>(parameters));
    } catch (const ComponentError& error) {
      return error.pointer() + ": " + error.what();
    }
    return "no fault";
  };
  REQUIRE(fault(defaults("given")) == "/yaw: a given heading needs a yaw");
  REQUIRE(fault(defaults("gyrocompass")) == "/gyro_bias: gyrocompassing needs the gyro_bias (1-sigma) that limits it");
  REQUIRE(fault(with(defaults("course"), "min_speed", number(0.2))) ==
          "/min_speed: a course needs more speed than rest allows");
  REQUIRE(fault(defaults("course")) == "no fault");
}

TEST_CASE("alignment: the spec is complete") {
  const auto spec = CoarseAlignment::spec();
  REQUIRE(spec.type == "coarse_alignment");
  REQUIRE(!spec.summary.empty());
  REQUIRE(!spec.source.empty());
  REQUIRE(!spec.example.empty());
  REQUIRE(undocumented(spec.parameters) == "");
  REQUIRE(spec.inputs.size() == 2);
  REQUIRE(spec.inputs[0].fields.size() == 6);
  REQUIRE(spec.inputs[1].is_optional);
}

namespace {

/// A recorded file through the csv source, one sample ahead.
class Recording {
 public:
  Recording(const std::string& path, const std::vector<std::pair<std::string, ParameterValue>>& columns) {
    std::vector<std::pair<std::string, ParameterValue>> specified;
    for (const auto& [name, si_unit] : columns)
      specified.push_back({name, object({{"unit", si_unit}, {"kind", text(is_imu(name) ? "rate" : "level")}})});
    source_ = std::make_unique<csv::CsvSource>(bind(object({{"path", text(path)},
                                                            {"columns", object(specified)},
                                                            {"delimiter", text(",")},
                                                            {"comment", text("#")},
                                                            {"header", boolean(true)},
                                                            {"invalid_rows", text("error")}})));
    struct Silent : Reporter {
      void warn(const std::string&, const std::string&, int, const std::string&) override {}
    } silent;
    source_->open(silent);
    memory_ = binnacle::testing::SourceCaller(*source_).fresh_memory(0);
  }
  bool next() {
    auto next = binnacle::testing::SourceCaller(*source_).next(memory_.data());
    if (next.status != SourceStatus::sample) return false;
    fields = std::move(next.sample.fields);
    t = next.sample.t;
    t0 = next.sample.t0;
    return true;
  }
  Time t = no_time, t0 = no_time;
  std::vector<double> fields;

 private:
  static bool is_imu(const std::string& name) { return name[0] == 'g' || name[0] == 'a'; }
  std::unique_ptr<csv::CsvSource> source_;
  std::vector<std::byte> memory_;
};

struct RecordedDrive {
  const char* folder;
  Vector3d mount;  // deg
};

}  // namespace

TEST_CASE("alignment: on recorded drives, against the reference", "[data]") {
  const auto drives = binnacle::test::recorded_data("drives");
  if (!drives) return;
  for (const auto& drive :
       std::vector<RecordedDrive>{{"mixed-road-long-drive-large-mount-001", {170.79, 60.50, 167.45}},
                                  {"parkinglot-maneuvers", {-1.82, -24.60, 96.87}},
                                  {"urban-medium-turn-loop-nominal-001", {-1.17, -0.02, 2.59}},
                                  {"urban-mixed-turns-nominal-001", {-2.01, 1.61, 265.33}},
                                  {"urban-stop-go-large-mount-001", {170.75, 60.59, 168.91}}}) {
    const auto file = [&](const char* name) { return (*drives / drive.folder / name).string(); };
    Recording imu(file("imu.csv.gz"), {{"gx_radps", unit("rad/s")},
                                       {"gy_radps", unit("rad/s")},
                                       {"gz_radps", unit("rad/s")},
                                       {"ax_mps2", unit("m/s^2")},
                                       {"ay_mps2", unit("m/s^2")},
                                       {"az_mps2", unit("m/s^2")}});
    Recording gnss(file("gnss.csv.gz"),
                   {{"vn_mps", unit("m/s")}, {"ve_mps", unit("m/s")}, {"lat_deg", unit("rad", deg)}});
    // Raw axes to forward-left-up by the mount angles, then to forward-right-down.
    const Matrix3d C =
        Vector3d(1, -1, -1).asDiagonal() * sd::dcm_from_quaternion(sd::quaternion_from_euler(drive.mount * deg));
    Aligner aligner(with(defaults("course"), "velocity_sd", number(0.1)));
    bool has_gnss = gnss.next();
    while (imu.next() && aligner.out.attitudes.empty()) {
      for (; has_gnss && gnss.t <= imu.t; has_gnss = gnss.next())
        if (gnss.t < imu.t) aligner.gnss(gnss.t, gnss.fields[0], gnss.fields[1], gnss.fields[2]);
      aligner.imu(imu.t0, imu.t, C * Vector3d(imu.fields[0], imu.fields[1], imu.fields[2]),
                  C * Vector3d(imu.fields[3], imu.fields[4], imu.fields[5]));
    }
    INFO(drive.folder);
    REQUIRE(aligner.out.attitudes.size() == 1);
    const auto& attitude = aligner.out.attitudes[0];
    Recording reference(file("reference_attitude.csv.gz"), {{"roll_deg", unit("rad", deg)},
                                                            {"pitch_deg", unit("rad", deg)},
                                                            {"yaw_deg", unit("rad", deg)}});
    while (reference.next() && reference.t < attitude.t) continue;
    // An angle of exactly zero is one that the reference does not know yet.
    const Vector3d expected(reference.fields[0], reference.fields[1], reference.fields[2]);
    const Vector3d sigma = attitude.P.diagonal().cwiseSqrt() / deg;
    std::cout << "coarse_alignment: " << drive.folder << " at " << seconds(attitude.t) << " s, 1-sigma (n e d) "
              << sigma.transpose() << " deg";
    const char* names[] = {"roll", "pitch", "yaw"};
    for (int i = 0; i < 3; ++i) {
      const double error = wrapped(attitude.values[i] - expected[i]) / deg;
      std::cout << ", " << names[i] << " " << attitude.values[i] / deg;
      if (expected[i] == 0) continue;
      std::cout << " (" << (error < 0 ? "" : "+") << error << " against the reference)";
      REQUIRE(std::abs(error) < 3 * sigma[i]);
    }
    std::cout << "\n";
  }
}
