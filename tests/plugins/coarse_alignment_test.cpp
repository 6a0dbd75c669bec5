// SPDX-License-Identifier: Apache-2.0
// Coarse alignment: signs in every quadrant, its covariance, no attitude without rest.
#include "coarse_alignment/coarse_alignment.hpp"

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "aligner.hpp"
#include "catch.hpp"
#include "coarse_alignment/rest_window.hpp"
#include "spec_text.hpp"
#include "strapdown/rotation.hpp"

namespace coarse_alignment_test {

using namespace binnacle;
using namespace binnacle::aligner;

TEST_CASE("alignment: heading given, roll and pitch in every quadrant") {
  for (const auto& euler : every_quadrant) {
    Aligner aligner(with_member(defaults("given"), "yaw", euler.z()));
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
    Aligner aligner(with_member(defaults("given"), "yaw", 0));
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
      auto parameters = with_member(defaults("gyrocompass"), "gyro_bias", 1e-8);
      parameters = with_member(parameters, "accelerometer_bias", 1e-4);
      Aligner aligner(with_member(parameters, "latitude", lat));
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
  const auto parameters = with_member(defaults("gyrocompass"), "gyro_bias", 1e-7);
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
  auto parameters = with_member(defaults("gyrocompass"), "latitude", 43 * deg);
  Drive drive;
  Aligner coarse(with_member(parameters, "gyro_bias", 20 * deg / 3600));
  drive.run(coarse);
  REQUIRE(coarse.out.attitudes.empty());
  // Promised 0.1 deg/h, but 10 deg/h off: the horizontal rate is not the earth's.
  drive.gyro_bias = Vector3d(10, 0, 0) * deg / 3600;
  Aligner liar(with_member(parameters, "gyro_bias", 0.1 * deg / 3600));
  drive.run(liar);
  REQUIRE(liar.out.attitudes.empty());
}

TEST_CASE("alignment: the covariance, written out") {
  auto parameters = with_member(defaults("given"), "yaw", 120 * deg);
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

TEST_CASE("alignment: nothing while moving") {
  // Quiet as at rest, but the receiver says 10 m/s.
  Aligner cruising(with_member(defaults("given"), "yaw", 0));
  for (int k = 0; k <= 2000; ++k) {
    cruising.imu(k ? nanoseconds(k * 0.01 - 0.01) : no_time, nanoseconds(k * 0.01), Vector3d::Zero(), {0, 0, -g});
    if (k % 50 == 0) cruising.gnss(nanoseconds(k * 0.01), 10, 0, 0.7);
  }
  REQUIRE(cruising.out.attitudes.empty());

  // A drive that is recorded from the middle, without rest: no course either.
  for (const char* heading : {"given", "course"}) {
    Aligner moving(with_member(defaults(heading), "yaw", 0));
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
    Aligner aligner(with_member(defaults("given"), "yaw", 0));
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
  binnacle::coarse_alignment::RestFindings findings;
  const auto add = [&](double fx) { return window.add(limits, 1, {0.001, 0, 0}, {fx, 0, -g}, findings); };
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
    Aligner aligner(with_member(defaults("given"), "yaw", 0));
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
  Aligner hasty(with_member(defaults("course"), "max_coast", 20));
  drive.run(hasty);
  REQUIRE(hasty.out.attitudes.empty());
}

TEST_CASE("alignment: course uncertainty from reported velocity deviations, turn and slip") {
  const auto heading_sd = [](const Json& parameters, double sd_n, double sd_e) {
    Aligner aligner(parameters);
    Drive drive;
    drive.has_gnss = false;
    drive.run(aligner);
    aligner.gnss(nanoseconds(4.0), 0, 4, unknown, sd_n, sd_e);  // to the east
    return std::sqrt(aligner.out.attitudes.at(0).P(2, 2));
  };
  const auto parameters = with_member(defaults("course"), "sigma_heading", 0);
  REQUIRE(std::abs(heading_sd(parameters, 0.4, 9.0) - 0.1) < 1e-3);
  REQUIRE(std::abs(heading_sd(parameters, unknown, unknown) - 0.05) < 1e-3);
  REQUIRE(std::abs(heading_sd(with_member(parameters, "velocity_sd", 0.8), 0.4, 9.0) - 0.2) < 1e-3);
  REQUIRE(std::abs(heading_sd(with_member(parameters, "sigma_heading", 0.3), unknown, unknown) -
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
  Aligner aligner(with_member(with_member(defaults("given"), "yaw", 40 * deg), "every", 1));
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
  const auto parameters = with_member(with_member(defaults("given"), "yaw", drive.euler.z()), "gyro_drift", 0);
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
  const auto fault = [](const Json& parameters) -> std::string {
    try {
      binnacle::testing::bind<CoarseAlignment>({parameters});
    } catch (const ComponentError& error) {
      return error.pointer() + ": " + error.what();
    }
    return "no fault";
  };
  REQUIRE(fault(defaults("given")) == "/yaw: a given heading needs a yaw");
  REQUIRE(fault(defaults("gyrocompass")) == "/gyro_bias: gyrocompassing needs the gyro_bias (1-sigma) that limits it");
  REQUIRE(fault(with_member(defaults("course"), "min_speed", 0.2)) ==
          "/min_speed: a course needs more speed than rest allows");
  REQUIRE(fault(defaults("course")) == "no fault");
}

TEST_CASE("alignment: the spec is complete") {
  const auto spec = CoarseAlignment::spec();
  REQUIRE(spec.type == "coarse_alignment");
  REQUIRE(!spec.summary.empty());
  REQUIRE(!spec.source.empty());
  REQUIRE(!spec.example.empty());
  REQUIRE(binnacle::test::undocumented(spec.parameters) == "");
  REQUIRE(spec.inputs.size() == 2);
  REQUIRE(spec.inputs[0].fields.size() == 6);
  REQUIRE(spec.inputs[1].is_optional);
}

}  // namespace coarse_alignment_test
