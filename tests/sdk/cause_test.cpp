// SPDX-License-Identifier: Apache-2.0
// The likely cause of a doubt: clocks, axes, signs and scales, found in simulated data, and not found where all is right.
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "../../sdk/score/axis_words.hpp"
#include "../../sdk/score/field_fit.hpp"
#include "../../sdk/score/input_fit.hpp"
#include "binnacle/geodesy.hpp"
#include "catch.hpp"
#include "command.hpp"

namespace cause_test {

using namespace binnacle;
using namespace binnacle::score;

namespace {

struct Imu {
  Time t0, t;
  Turns increment;
};

struct Fix {
  Time t;
  Eigen::Vector3d position, velocity;
};

/// A car that speeds up, brakes and turns on a plane for ten minutes; its sensors are noisy.
struct Drive {
  std::vector<Imu> imu;
  std::vector<Fix> fixes;
};

double speed(double t) { return 11 + 3 * std::sin(0.13 * t) + 2 * std::sin(0.6 * t + 1); }
double heading(double t) { return 1.5 * std::sin(0.11 * t) + 0.9 * std::sin(0.047 * t + 2) + 0.004 * t; }

/// The antenna is `ahead` of the rear axle: so its course leads the heading.
Drive drive(unsigned seed, double ahead = 0) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) { return sigma * normal(generator); };
  Drive drive;
  Eigen::Vector3d lla(0.84, 0.2, 500);
  constexpr double dt = 0.01, g = 9.81;
  for (int i = 0; i < 60000; ++i) {
    const double a = i * dt, b = a + dt, v = speed(a + dt / 2), psi = heading(a + dt / 2);
    const double turn = heading(b) - heading(a), faster = speed(b) - speed(a);
    Turns increment;
    increment << noise(2e-5), noise(2e-5), turn + 2e-3 * dt + noise(2e-5), faster + noise(1e-3),
        v * turn + 0.3 * dt + noise(1e-3), -g * dt + noise(1e-3);
    drive.imu.push_back({nanoseconds(a), nanoseconds(b), increment});
    const auto radii = geodesy::radii(lla[0]);
    lla[0] += v * std::cos(psi) * dt / (radii.meridian + lla[2]);
    lla[1] += v * std::sin(psi) * dt / ((radii.transverse + lla[2]) * std::cos(lla[0]));
    if ((i + 1) % 50 != 0) continue;
    const double north = noise(0.5) / radii.meridian, east = noise(0.5) / radii.meridian;
    const double course = heading(b) + std::atan(ahead * (heading(b) - heading(a)) / dt / speed(b));
    drive.fixes.push_back(
        {nanoseconds(b),
         lla + Eigen::Vector3d(north, east, noise(1)),
         {speed(b) * std::cos(course) + noise(0.05), speed(b) * std::sin(course) + noise(0.05), noise(0.05)}});
  }
  return drive;
}

const FixFields fields{
    0, "gnss", "fix", "/fix", {}, {{0, 1, 2}, {"vn", "ve", "vd"}}, VectorFields{{3, 4, 5}, {"lat", "lon", "height"}}};
const InertialFields inertial{1, "imu", {{0, 1, 2}, {"wx", "wy", "wz"}, true}, {{3, 4, 5}, {"fx", "fy", "fz"}, true}};

/// What the channel of fixes alone shows, when each is spoilt.
std::vector<std::string> field_words(const std::function<void(Fix&)>& spoil, unsigned seed = 1) {
  FieldFit fit;
  for (Fix fix : drive(seed).fixes) {
    spoil(fix);
    fit.add(fix.t, fix.position, fix.velocity);
  }
  return fit.words(fields);
}

/// What both channels show, when the labels of fixes are late and the input is spoilt.
InputFit fitted(double fixes_late, const std::function<void(Turns&)>& spoil, unsigned seed = 1, double imu_late = 0,
                double ahead = 0) {
  InputFit fit;
  const Drive all = drive(seed, ahead);
  std::size_t next = 0;
  for (const Imu& sample : all.imu) {
    for (; next < all.fixes.size() && all.fixes[next].t <= sample.t; ++next)
      fit.add_velocity(all.fixes[next].t + nanoseconds(fixes_late), all.fixes[next].velocity[0],
                       all.fixes[next].velocity[1]);
    Turns increment = sample.increment;
    spoil(increment);
    fit.add_input(sample.t0 + nanoseconds(imu_late), sample.t + nanoseconds(imu_late), increment);
  }
  return fit;
}

std::vector<std::string> words(const std::function<void(Turns&)>& spoil, bool velocity_is_right = true) {
  return axis_words(fitted(0, spoil).axes(), inertial, fields, velocity_is_right);
}

bool has(const std::vector<std::string>& all, const std::string& part) {
  for (const auto& text : all)
    if (text.find(part) != std::string::npos) return true;
  return false;
}

}  // namespace

TEST_CASE("right data get no word of a cause", "[cause]") {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    CHECK(field_words([](Fix&) {}, seed).empty());
    const InputFit fit = fitted(
        0, [](Turns&) {}, seed);
    INFO(fit.figures());
    CHECK_FALSE(fit.shift());
    CHECK(axis_words(fit.axes(), inertial, fields, true).empty());
  }
}

TEST_CASE("a receiver that stands, or whose noise is all there is, gets no word", "[cause]") {
  CHECK(field_words([](Fix& fix) {
          fix.position = {0.84, 0.2, 500};
          fix.velocity = 0.01 * fix.velocity;
        }).empty());
  CHECK_FALSE(fitted(2, [](Turns& increment) { increment *= 0; }).shift());
}

TEST_CASE("velocity fields that are swapped, of wrong sign or scale are named", "[cause]") {
  const auto swapped = field_words([](Fix& fix) { std::swap(fix.velocity[0], fix.velocity[1]); });
  CHECK(swapped.size() == 1);
  CHECK(has(swapped, "'vn' of 'gnss' follows the motion east, as its position shows it: are 'vn' and 've' swapped?"));
  const auto negated = field_words([](Fix& fix) { fix.velocity[0] *= -1; });
  CHECK(negated.size() == 1);
  CHECK(has(negated, "'vn' of 'gnss' follows the motion south, as its position shows it: is its sign wrong?"));
  for (const double scale : {1.1, 2.0, 3.6}) {
    const auto scaled = field_words([&](Fix& fix) { fix.velocity *= scale; });
    CHECK(scaled.size() == 2);
    CHECK(has(scaled, "times the motion north, as its position shows it: is its unit or scale wrong?"));
    CHECK(has(scaled, "times the motion east, as its position shows it: is its unit or scale wrong?"));
  }
  CHECK(has(field_words([](Fix& fix) { fix.velocity *= 2; }), "is 2 times the motion"));
}

TEST_CASE("latitude and longitude that are swapped are named, not the velocity", "[cause]") {
  const auto swapped = field_words([](Fix& fix) { std::swap(fix.position[0], fix.position[1]); });
  CHECK(swapped.size() == 1);
  CHECK(has(swapped, "'lat' and 'lon' change places: are they swapped?"));
}

TEST_CASE("velocities along other axes are not said to be scaled", "[cause]") {
  const auto turned = field_words([](Fix& fix) {
    const double n = fix.velocity[0], e = fix.velocity[1];
    fix.velocity[0] = 0.9 * n + 0.436 * e;
    fix.velocity[1] = -0.436 * n + 0.9 * e;
  });
  CHECK(has(turned, "only in part: is it along other axes?"));
  CHECK_FALSE(has(turned, "scale"));
}

TEST_CASE("fixes that are labelled late fit earlier, and the reverse", "[cause]") {
  const auto nothing = [](Turns&) {};
  for (const double late : {0.2, 2.0, 18.0, -0.2, -5.0}) {
    const auto shift = fitted(late, nothing).shift();
    REQUIRE(shift);
    CHECK(std::abs(shift->seconds - late) < 0.03);
    CHECK(shift->sigma < 0.05);
  }
  const auto shift = fitted(0, nothing, 1, 0.5).shift();  // a late input: the fixes fit later
  REQUIRE(shift);
  CHECK(std::abs(shift->seconds - -0.5) < 0.03);
}

TEST_CASE("an antenna far ahead of the rear axle is no clock", "[cause]") {
  for (const double ahead : {-2.0, 2.0, 5.0}) {
    const InputFit fit = fitted(
        0, [](Turns&) {}, 1, 0, ahead);
    INFO(fit.figures());
    CHECK_FALSE(fit.shift());
  }
}

TEST_CASE("a clock is found with axes that are wrong too", "[cause]") {
  const InputFit fit = fitted(2, [](Turns& increment) { increment[2] *= -1; });
  REQUIRE(fit.shift());
  CHECK(std::abs(fit.shift()->seconds - 2) < 0.03);
  CHECK(has(axis_words(fit.axes(), inertial, fields, true), "is the sign of 'wz' wrong?"));
}

TEST_CASE("gyros and accelerometers with wrong axes, signs and scales are named", "[cause]") {
  CHECK(has(words([](Turns& increment) { increment[2] *= -1; }),
            "the gyros of 'imu' turn against the course of 'gnss': is the sign of 'wz' wrong?"));
  CHECK(has(words([](Turns& increment) { std::swap(increment[0], increment[2]); }),
            "turn with the course of 'gnss' about +'wx', while the vertical of the accelerometers is -'fz'"));
  CHECK(has(words([](Turns& increment) { increment.head<3>() *= 1.2; }), "are 1.2 times those of the course"));
  CHECK(has(words([](Turns& increment) { increment.head<3>() *= 57.3; }), "are 57.3 times those of the course"));
  CHECK(has(words([](Turns& increment) { std::swap(increment[3], increment[4]); }),
            "forward acceleration along +'fy', to the right along +'fx'"));
  CHECK(has(words([](Turns& increment) { increment[4] *= -1; }), "left-handed"));
  CHECK(has(words([](Turns& increment) { increment.tail<3>() /= 9.81; }), "0.102 times gravity"));
}

TEST_CASE("a sensor that is mounted otherwise is no wrong axis", "[cause]") {
  CHECK(words([](Turns& increment) {  // forward-right-down to forward-left-up
          for (const int i : {1, 2, 4, 5}) increment[i] *= -1;
        })
            .empty());
  CHECK(words([](Turns& increment) {  // turned by a right angle about the vertical
          for (const int i : {0, 3}) {
            std::swap(increment[i], increment[i + 1]);
            increment[i + 1] *= -1;
          }
        })
            .empty());
}

TEST_CASE("a sensor mounted askew is named where a measurement takes its x axis to be ahead", "[cause]") {
  for (const double angle : {-0.35, 0.02, 0.35, 1.57}) {
    const auto turned = [&](Turns& increment) {  // the sensor's x axis lies `angle` to the left of ahead
      for (const int i : {0, 3}) {
        const double x = increment[i], y = increment[i + 1];
        increment[i] = std::cos(angle) * x - std::sin(angle) * y;
        increment[i + 1] = std::sin(angle) * x + std::cos(angle) * y;
      }
    };
    const InputFit fit = fitted(0, turned);
    INFO(fit.figures());
    CHECK(axis_words(fit.axes(), inertial, fields, true).empty());
    InertialFields on_wheels = inertial;
    on_wheels.rolls = "nhc";
    const auto all = axis_words(fit.axes(), on_wheels, fields, true);
    CHECK(all.size() == (std::abs(angle) > 0.1));
    if (std::abs(angle) < 0.1) continue;
    CHECK(has(all, angle > 0 ? "deg to the right of the x axis" : "deg to the left of the x axis"));
    INFO(all[0]);
    const double found = std::stod(all[0].substr(all[0].find("acceleration ") + 13));  // to a degree or two
    CHECK(std::abs(found - std::abs(angle) * 180 / std::numbers::pi) < 2);
  }
}

TEST_CASE("where no position vouches for the velocity, the course is called a mirror", "[cause]") {
  InputFit fit;
  const Drive all = drive(1);
  std::size_t next = 0;
  for (const Imu& sample : all.imu) {
    for (; next < all.fixes.size() && all.fixes[next].t <= sample.t; ++next)
      fit.add_velocity(all.fixes[next].t, all.fixes[next].velocity[1], all.fixes[next].velocity[0]);
    fit.add_input(sample.t0, sample.t, sample.increment);
  }
  CHECK(has(axis_words(fit.axes(), inertial, fields, false), "'vn' and 've' swapped, or is one's sign wrong?"));
}

TEST_CASE("a run that is not ok names the likely cause, in its words, its exit and its JSON", "[cause]") {
  const test::Workbench bench;
  const std::string simulated = BINNACLE_TEST_PROJECT "/configs/faults/simulated.json";
  const auto err = [&](const std::string& variant) {
    return test::binnacle(bench, {"run", simulated, "--variant", variant, "--quiet"}).err;
  };
  const auto has_text = [&](const std::string& text, const std::string& part) { return has({text}, part); };
  CHECK(err("clean").empty());
  const std::string clock = err("fixes late 2 s"), axes = err("velocity north and east swapped");
  INFO(clock << axes);
  CHECK(has_text(clock,
                 "warning[B119] /filters/ins/measurements/fix: the samples of 'bad_gnss' fit those of 'imu' best"));
  CHECK(has_text(clock, "s earlier than they are labelled"));
  CHECK(has_text(axes, "warning[B120] /filters/ins/measurements/fix: the velocity field 'vn' of 'bad_gnss' follows"));
  CHECK_FALSE(has_text(axes, "B119"));
  const auto json = test::binnacle(bench, {"run", simulated, "--variant", "velocity scaled 2", "--json", "--quiet"});
  CHECK(has_text(json.out, "\"likely_causes\""));
  CHECK(has_text(json.out, "is 2 times the motion north"));
}

}  // namespace cause_test
