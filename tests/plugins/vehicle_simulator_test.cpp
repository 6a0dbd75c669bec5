// SPDX-License-Identifier: Apache-2.0
// The vehicle simulator: its trajectory against other mathematics, and its manners.
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "binnacle/unit.hpp"
#include "catch.hpp"
#include "simulated_drive.hpp"
#include "spec/check.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"

namespace vehicle_simulator_test {

using namespace binnacle;
using namespace binnacle::simulated_drive;

namespace {

struct RefusedAt {
  std::string pointer, message;
};
RefusedAt refusal_of(const Json& segments, const Json& more = {}) {
  Json config = {{"start", munich}, {"segments", segments}};
  config.update(more.is_null() ? Json::object() : more);
  try {
    Drive drive(config);
  } catch (const ComponentError& error) {
    return {error.pointer(), error.what()};
  }
  return {};
}

}  // namespace

// ---- the trajectory

TEST_CASE("free of errors, a mechanization of the increments reproduces the truth over ten minutes") {
  Json config = lively_drive(8);
  Drive drive(config);
  strapdown::Navigation nav;
  strapdown::Previous previous;
  double worst_position = 0.0, worst_velocity = 0.0, worst_attitude = 0.0;
  Time last = 0;
  while (const auto sample = drive.next()) {
    last = sample->t;
    if (sample->channel == VehicleSimulator::initial) {
      nav = {sample->triple(0), sample->triple(3), strapdown::quaternion_from_euler(sample->triple(6))};
    } else if (sample->channel == VehicleSimulator::imu) {
      const strapdown::Increment increment{seconds(sample->t - sample->t0), sample->triple(0), sample->triple(3)};
      nav = strapdown::advance(nav, increment, previous);
      previous = strapdown::remember(previous, increment);
    } else if (sample->channel == VehicleSimulator::truth && sample->t > 0) {
      // At one instant truth comes before the increment that ends there.
      const auto imu = drive.next();
      REQUIRE(imu->t == sample->t);
      const strapdown::Increment increment{seconds(imu->t - imu->t0), imu->triple(0), imu->triple(3)};
      nav = strapdown::advance(nav, increment, previous);
      previous = strapdown::remember(previous, increment);
      worst_position = std::max(worst_position, metres(sample->triple(0), nav.lla));
      worst_velocity = std::max(worst_velocity, (sample->triple(3) - nav.v_n).norm());
      const auto q = strapdown::quaternion_from_euler(sample->triple(6));
      worst_attitude = std::max(worst_attitude, strapdown::attitude_minus(q, nav.q_nb).norm());
    }
  }
  INFO("seconds " << seconds(last) << ", worst: " << worst_position << " m, " << worst_velocity << " m/s, "
                  << worst_attitude << " rad");
  REQUIRE(seconds(last) > 600.0);
  REQUIRE(worst_position < 0.010);
  REQUIRE(worst_velocity < 1e-4);
  REQUIRE(worst_attitude < 1e-7);
}

TEST_CASE("position is the integral of velocity to below 0.1 mm over an hour") {
  const Trajectory trajectory = trajectory_of(lively_drive(43));
  const double end = seconds(trajectory.duration());
  REQUIRE(end > 3600.0);
  const auto rate = [&](double t, const Vector3d& lla) -> Vector3d {
    const Vector3d v = trajectory.motion(t).v_n;
    const auto r = strapdown::radii(lla[0]);
    return {v[0] / (r.meridian + lla[2]), v[1] / ((r.transverse + lla[2]) * std::cos(lla[0])), -v[2]};
  };
  Vector3d lla = trajectory.motion(0.0).lla;
  double worst = 0.0;
  const auto joints = trajectory.joints();
  for (std::size_t j = 0; j + 1 < joints.size(); ++j) {  // classical Runge–Kutta in steps of 0.05 s at most
    const int steps = static_cast<int>(std::ceil((joints[j + 1] - joints[j]) / 0.05));
    const double h = (joints[j + 1] - joints[j]) / steps;
    for (int i = 0; i < steps; ++i) {
      const double t = joints[j] + i * h;
      const Vector3d k1 = rate(t, lla), k2 = rate(t + h / 2, lla + h / 2 * k1);
      const Vector3d k3 = rate(t + h / 2, lla + h / 2 * k2), k4 = rate(t + h, lla + h * k3);
      lla += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      worst = std::max(worst, metres(trajectory.motion(t + h).lla, lla));
    }
  }
  INFO("worst " << worst << " m");
  REQUIRE(worst < 1e-5);
}

TEST_CASE("a drive along a parallel has the longitude of the closed form") {
  const Trajectory trajectory = trajectory_of(
      {{"start", {{"lat", "60 deg"}, {"lon", "179.9 deg"}, {"height", 100}, {"heading", "90 deg"}, {"speed", 30}}},
       {"segments", Json::array({{{"do", "straight"}, {"duration", 3600}}})}});
  const Vector3d lla = trajectory.motion(3600.0).lla;
  const double expected =
      179.9 * degree + 30.0 * 3600.0 / ((strapdown::radii(60 * degree).transverse + 100) * std::cos(60 * degree));
  REQUIRE(std::abs(lla[0] - 60 * degree) * 6.4e6 < 1e-5);
  REQUIRE(lla[1] < 0.0);  // across the date line
  REQUIRE(std::abs(lla[1] + 2 * std::numbers::pi - expected) * 3.2e6 < 1e-5);
  REQUIRE(lla[2] == 100.0);
}

TEST_CASE("at rest the sensors feel earth rate and gravity") {
  Json config = standing(10);
  config["perfect"] = true;
  config["imu_kind"] = "rate";
  const auto samples = Drive(config).of(VehicleSimulator::imu);
  REQUIRE(samples.size() == 2000);
  const double lat = 48.1 * degree, heading = 30 * degree;
  const Vector3d earth(std::cos(lat) * std::cos(heading), -std::cos(lat) * std::sin(heading), -std::sin(lat));
  for (const auto& sample : samples) {
    REQUIRE((sample.triple(0) - 7.292115e-5 * earth).norm() < 1e-16);
    REQUIRE((sample.triple(3) - Vector3d(0, 0, -strapdown::gravity(lat, 520).down)).norm() <
            1e-11);  // 10 s in doubles: 2e-15/5e-3
  }
}

TEST_CASE("angular rate and specific force are continuous where manoeuvres meet") {
  const Trajectory trajectory = trajectory_of(lively_drive(1));
  double largest_rate = 0.0, largest_force = 0.0;
  for (const double t : trajectory.joints()) {
    if (t == 0.0 || t == seconds(trajectory.duration())) continue;
    const Inertial before = simulation::inertial(trajectory.motion(t - 1e-7)),
                   after = simulation::inertial(trajectory.motion(t + 1e-7));
    largest_rate = std::max(largest_rate, (after.omega_ib_b - before.omega_ib_b).norm());
    largest_force = std::max(largest_force, (after.f_b - before.f_b).norm());
  }
  INFO(largest_rate << " rad/s, " << largest_force << " m/s^2");
  REQUIRE(largest_rate < 1e-6);
  REQUIRE(largest_force < 1e-6);
}

TEST_CASE("velocity, attitude and their derivatives belong together") {
  const Trajectory trajectory = trajectory_of(lively_drive(1));
  const double h = 1e-4;
  for (double t = 0.5; t < seconds(trajectory.duration()) - 1.0; t += 0.37) {
    const Motion before = trajectory.motion(t - h), now = trajectory.motion(t), after = trajectory.motion(t + h);
    INFO("t = " << t);
    REQUIRE(((after.v_n - before.v_n) / (2 * h) - now.dv_n).norm() < 1e-6);
    const auto moved = [&](double dt) { return strapdown::position_minus(trajectory.motion(t + dt).lla, now.lla); };
    const double d = 0.01;
    const Vector3d v_n = (moved(-2 * d) - moved(2 * d) + 8 * (moved(d) - moved(-d))) / (12 * d);
    REQUIRE((v_n - now.v_n).norm() < 5e-6);
    Vector3d turned = after.roll_pitch_yaw - before.roll_pitch_yaw;
    turned[2] = std::remainder(turned[2], 2 * std::numbers::pi);
    REQUIRE((turned / (2 * h) - now.euler_rates).norm() < 1e-6);
    // ω_ib_b from the change of attitude in inertial space, by other means than Euler rates
    const auto q = [&](const Motion& m) { return strapdown::quaternion_from_euler(m.roll_pitch_yaw); };
    const Vector3d turn_n =
        strapdown::quaternion_log(strapdown::quaternion_product(q(after), strapdown::quaternion_conjugate(q(before))));
    const Vector3d omega_in =
        strapdown::omega_ie_n(now.lla[0]) + strapdown::omega_en_n(now.lla[0], now.lla[2], now.v_n);
    const Vector3d omega_ib_b = strapdown::dcm_from_quaternion(q(now)).transpose() * (turn_n / (2 * h) + omega_in);
    REQUIRE((simulation::inertial(now).omega_ib_b - omega_ib_b).norm() < 1e-6);
  }
}

TEST_CASE("manoeuvres end where they are specified to") {
  const auto config = lively_drive(1);
  const Trajectory trajectory = trajectory_of(config);
  const ParameterValue value = checked<VehicleSimulator>(config);
  const auto segments = read_segments(Parameters(value));
  const auto at_end = [&](std::size_t i) {
    return trajectory.motion(seconds(segments[i].begin + segments[i].duration));
  };
  REQUIRE(std::abs(at_end(1).v_n.norm() - 14.0) < 1e-12);
  REQUIRE(std::abs(seconds(segments[1].duration) - (14.0 / 1.8 + 2.0)) < 1e-8);
  REQUIRE(std::abs(at_end(2).roll_pitch_yaw[2] - 125 * degree) < 1e-12);
  REQUIRE(std::abs(seconds(segments[2].duration) - (95.0 / 15.0 + 2.0)) < 1e-8);
  REQUIRE(std::abs(at_end(4).lla[2] - at_end(3).lla[2] - 6.0) < 1e-6);
  REQUIRE(std::abs(at_end(5).roll_pitch_yaw[2] - (125 - 200) * degree) < 1e-12);
  REQUIRE(std::abs(at_end(6).v_n.norm() - 22.0) < 1e-12);
  REQUIRE(at_end(8).v_n.norm() < 1e-12);
  const Motion downhill = trajectory.motion(seconds(segments[7].begin) + 3.5);
  REQUIRE(std::abs(std::atan2(downhill.v_n[2], downhill.v_n.head<2>().norm()) - 4 * degree) < 1e-12);
  REQUIRE(std::abs(downhill.roll_pitch_yaw[1] + 4 * degree) < 1e-12);
  const Motion right_turn = trajectory.motion(seconds(segments[2].begin) + 4.0);
  REQUIRE(std::abs(right_turn.roll_pitch_yaw[0] + 4 * degree / 9.80665 * 14.0 * 15 * degree) < 1e-9);
  const Motion braking = trajectory.motion(seconds(segments[8].begin) + 4.0);
  REQUIRE(std::abs(braking.roll_pitch_yaw[1] - 1.5 * degree / 9.80665 * -2.5) < 1e-9);
}

TEST_CASE("a manoeuvre shorter than its ramps still ends where it is specified to") {
  const Trajectory trajectory =
      trajectory_of({{"start", munich}, {"segments", Json::parse(R"([{"do": "accelerate", "to": 1, "acceleration": 2},
                                    {"do": "turn", "angle": "5 deg", "rate": "10 deg/s", "ramp": "0.1 s"}])")}});
  REQUIRE(trajectory.duration() == nanoseconds(2 * 1.0 / 2.0) + nanoseconds(0.6));
  REQUIRE(std::abs(trajectory.motion(1.6).v_n.norm() - 1.0) < 1e-12);
  REQUIRE(std::abs(trajectory.motion(1.6).roll_pitch_yaw[2] - 35 * degree) < 1e-12);
}

TEST_CASE("position depends on time alone, not on the rates asked for") {
  Json slow = lively_drive(1), fast = lively_drive(1);
  slow["imu_rate"] = 50;
  fast["imu_rate"] = 333;
  fast["gnss_rate"] = 7;
  REQUIRE(Drive(slow).of(VehicleSimulator::truth) == Drive(fast).of(VehicleSimulator::truth));
}

TEST_CASE("increments over a long interval are the sum of those over short ones") {
  const Trajectory trajectory = trajectory_of(lively_drive(1));
  const double end = seconds(trajectory.duration());
  for (double t = 0.0; t + 1.0 < end; t += 1.0) {
    const Inertial once = trajectory.increments(t, t + 1.0);
    Inertial sum{Vector3d::Zero(), Vector3d::Zero()};
    for (int i = 0; i < 64; ++i) {
      const Inertial part = trajectory.increments(t + i / 64.0, t + (i + 1) / 64.0);
      sum.omega_ib_b += part.omega_ib_b;
      sum.f_b += part.f_b;
    }
    REQUIRE((once.omega_ib_b - sum.omega_ib_b).norm() < 1e-9);
    REQUIRE((once.f_b - sum.f_b).norm() < 1e-7);
  }
}

TEST_CASE("the antenna is at the end of its lever arm, and moves with it") {
  Json config = lively_drive(1);
  config["gnss_rate"] = 200;
  config["truth_rate"] = 200;
  config["gnss"]["lever_arm"] = {0.6, -0.3, -1.5};
  const auto samples = Drive(config).rest();
  std::map<Time, Emitted> truth, fixes;
  for (const auto& sample : samples) {
    if (sample.channel == VehicleSimulator::truth) truth.emplace(sample.t, sample);
    if (sample.channel == VehicleSimulator::gnss) fixes.emplace(sample.t, sample);
  }
  REQUIRE(fixes.size() == truth.size());
  const Vector3d lever_arm(0.6, -0.3, -1.5);
  const Time step = nanoseconds(0.005);
  double worst_velocity = 0.0;
  for (const auto& [t, fix] : fixes) {
    const auto q = strapdown::quaternion_from_euler(truth.at(t).triple(6));
    const Vector3d expected =
        strapdown::position_plus(truth.at(t).triple(0), strapdown::dcm_from_quaternion(q) * lever_arm);
    REQUIRE(metres(fix.triple(0), expected) < 1e-8);
    if (fixes.count(t - step) == 0 || fixes.count(t + step) == 0) continue;
    const Vector3d moved =
        strapdown::ecef_from_lla(fixes.at(t + step).triple(0)) - strapdown::ecef_from_lla(fixes.at(t - step).triple(0));
    const Vector3d v_n = strapdown::C_en(fix.fields[0], fix.fields[1]).transpose() * moved / 0.01;
    worst_velocity = std::max(worst_velocity, (v_n - fix.triple(3)).norm());
  }
  INFO(worst_velocity << " m/s");
  REQUIRE(worst_velocity < 3e-5);  // the difference quotient is good to jerk·h²/6 = 2e-5
}

// ---- the samples

TEST_CASE("samples come in order of time, at their rates, with their intervals") {
  Json config = lively_drive(1);
  config["start_time"] = 1000;
  config["imu_rate"] = 300;  // no whole number of nanoseconds
  Drive drive(config);
  const auto samples = drive.rest();
  REQUIRE(samples.front().channel == VehicleSimulator::initial);
  Time last = samples.front().t;
  REQUIRE(last == nanoseconds(1000));
  Time imu_end = nanoseconds(1000);
  std::array<int, 4> count{};
  for (const auto& sample : samples) {
    REQUIRE(sample.t >= last);
    last = sample.t;
    ++count[static_cast<std::size_t>(sample.channel)];
    for (const double field : sample.fields) REQUIRE(std::isfinite(field));
    if (sample.channel == VehicleSimulator::imu) {
      REQUIRE(sample.t0 == imu_end);
      imu_end = sample.t;
      REQUIRE(std::abs(sample.t - sample.t0 - 3333333) <= 1);
    } else {
      REQUIRE(sample.t0 == no_time);
    }
  }
  const double duration = seconds(samples.back().t) - 1000;
  REQUIRE(count[VehicleSimulator::imu] == static_cast<int>(duration * 300 + 1e-6));
  REQUIRE(count[VehicleSimulator::gnss] == static_cast<int>(duration) + 1);
  REQUIRE(count[VehicleSimulator::truth] == static_cast<int>(duration) + 1);
  REQUIRE(count[VehicleSimulator::initial] == 1);
  REQUIRE(!drive.next());
  REQUIRE(drive.channels()[0].max_interval >= 3333334);
}

TEST_CASE("rates of zero silence fixes and truth") {
  Json config = standing(2);
  config["gnss_rate"] = 0;
  config["truth_rate"] = 0;
  const auto samples = Drive(config).rest();
  REQUIRE(samples.size() == 401);
}

TEST_CASE("rates are increments divided by their interval") {
  Json config = lively_drive(1);
  const auto increments = Drive(config).of(VehicleSimulator::imu);
  config["imu_kind"] = "rate";
  Drive drive(config);
  REQUIRE(drive.channels()[0].fields[0].kind == FieldKind::rate);
  REQUIRE(drive.channels()[0].fields[3].unit == "m/s^2");
  const auto rates = drive.of(VehicleSimulator::imu);
  for (std::size_t i = 0; i < rates.size(); i += 17)
    for (std::size_t k = 0; k < 6; ++k) REQUIRE(std::abs(rates[i].fields[k] * 0.005 - increments[i].fields[k]) < 1e-15);
}

TEST_CASE("equal seeds give equal samples, other seeds other ones") {
  Json config = lively_drive(1);
  config["perfect"] = false;
  Drive drive(config, 5);
  const auto first = drive.rest();
  drive.restart(5);
  REQUIRE(drive.rest() == first);
  REQUIRE(Drive(config, 5).rest() == first);
  const auto other = Drive(config, 6).rest();
  REQUIRE(other.size() == first.size());
  for (std::size_t i = 0; i < first.size(); ++i) REQUIRE(!(other[i] == first[i]));
}

TEST_CASE("restored memory continues as if uninterrupted, with another instance too") {
  Json config = lively_drive(1);
  config["perfect"] = false;
  Drive drive(config, 3);
  for (int i = 0; i < 4321; ++i) drive.next();
  const auto snapshot = drive.memory();
  const auto uninterrupted = drive.rest();
  Drive other(config, 99);
  other.memory() = snapshot;
  REQUIRE(other.rest() == uninterrupted);
}

TEST_CASE("no error's size changes the draws of another") {
  Json config = standing(3);
  const auto all = [](const Json& c) { return Drive(c, 11).rest(); };
  const auto base = all(config);
  const auto differing_channels = [&](const char* group, const Json& change) {
    Json changed = config;
    changed[group] = change;
    const auto samples = all(changed);
    std::array<bool, 4> differs{};
    for (std::size_t i = 0; i < base.size(); ++i)
      if (!(samples[i] == base[i])) differs[static_cast<std::size_t>(base[i].channel)] = true;
    return differs;
  };
  REQUIRE(differing_channels("gnss", {{"position_sigma", 9}}) == std::array{false, true, false, false});
  REQUIRE(differing_channels("gyro", {{"noise", "3 deg/sqrt(h)"}}) == std::array{true, false, false, false});
  REQUIRE(differing_channels("initial_sigma", {{"tilt", 0}}) == std::array{false, false, false, true});

  config["gyro"] = {{"noise", Json::array({0, 0, 1e-3})}};
  const auto one = Drive(config, 11).of(VehicleSimulator::imu);
  config["gyro"] = {{"noise", Json::array({1e-2, 0, 1e-3})}, {"scale", "1 %"}};
  config["accel"] = {{"bias", "1 g"}, {"noise", 0}};
  const auto two = Drive(config, 11).of(VehicleSimulator::imu);
  double largest = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i)
    largest = std::max(largest, std::abs(one[i].fields[2] - two[i].fields[2]));
  REQUIRE(largest < 1e-7);  // 1 % of earth rate over 5 ms is 4e-9; another draw would be 1e-4
}

// ---- what is refused

TEST_CASE("segments that make no drive are refused at the member that is wrong") {
  const auto check = [](const char* segments, const char* pointer, const char* message) {
    const RefusedAt refusal = refusal_of(Json::parse(segments));
    INFO(segments);
    REQUIRE(refusal.pointer == pointer);
    REQUIRE(refusal.message == message);
  };
  check("[]", "/segments", "needs at least one segment");
  check(R"([{"do": "still"}])", "/segments/0", "'still' needs 'duration'");
  check(R"([{"do": "accelerate", "to": 5, "duration": 9}, {"do": "still", "duration": 3}])", "/segments/1/do",
        "the vehicle moves at 5 m/s here; brake to 0 before 'still'");
  check(R"([{"do": "accelerate", "to": 5, "duration": 9}, {"do": "accelerate", "acceleration": -2, "duration": 9}])",
        "/segments/1/acceleration", "brakes from 5 m/s to -9 m/s; the speed must not fall below zero");
  check(R"([{"do": "accelerate", "to": 5, "acceleration": -1}])", "/segments/0/acceleration",
        "must be positive to change by 5");
  check(R"([{"do": "accelerate", "to": 5, "acceleration": 1, "duration": 3}])", "/segments/0",
        "'accelerate' needs exactly two of 'duration', 'acceleration', 'to'");
  check(R"([{"do": "accelerate", "to": 0, "acceleration": 1}])", "/segments/0/to",
        "there is nothing to change; use 'straight' with a duration");
  check(R"([{"do": "accelerate", "to": 1, "acceleration": 1e-7}])", "/segments/0/acceleration",
        "is so small that it takes more than 1e6 s");
  check(R"([{"do": "accelerate", "to": 1, "acceleration": 1e4}])", "/segments/0/acceleration",
        "is so large that it takes less than 1 ms");
  check(R"([{"do": "turn", "angle": 1, "duration": 3}])", "/segments/0/do",
        "the vehicle stands still here; accelerate before 'turn'");
  check(R"([{"do": "climb", "height": 1, "duration": 3}])", "/segments/0/do",
        "the vehicle stands still here; accelerate before 'climb'");
  check(R"([{"do": "accelerate", "to": 5, "duration": 9}, {"do": "turn", "angle": 1}])", "/segments/1",
        "'turn' needs exactly two of 'duration', 'rate', 'angle'");
  check(R"([{"do": "accelerate", "to": 5, "duration": 9}, {"do": "climb", "duration": 1}])", "/segments/1",
        "'climb' needs exactly one of 'slope', 'height'");
  check(R"([{"do": "accelerate", "to": 5, "duration": 9}, {"do": "climb", "height": 90, "duration": 10}])",
        "/segments/1/height", "cannot be reached within 10 s at 5 m/s; 28.5356 m would be a slope of 45 deg");
  check(R"([{"do": "straight", "duration": 9, "angle": 2}])", "/segments/0/angle", "'straight' does not take 'angle'");
}

TEST_CASE("a list that cannot be driven twice is refused in its second pass") {
  const auto refusal =
      refusal_of(Json::parse(R"([{"do": "still", "duration": 1}, {"do": "accelerate", "to": 2, "duration": 5}])"),
                 {{"repeat", 2}});
  REQUIRE(refusal.pointer == "/segments/0/do");
  REQUIRE(refusal.message == "the vehicle moves at 2 m/s here; brake to 0 before 'still' (in pass 2)");
}

TEST_CASE("a drive to the pole is refused") {
  const auto refusal = refusal_of(Json::parse(R"([{"do": "straight", "duration": 3600}])"),
                                  {{"start", {{"lat", "89 deg"}, {"speed", 30}}}});
  REQUIRE(refusal.pointer == "/start/lat");
}

// ---- what it says of itself

TEST_CASE("the declaration is complete and its example works") {
  const ComponentSpec spec = VehicleSimulator::spec();
  REQUIRE(!spec.summary.empty());
  REQUIRE(!spec.source.empty());
  REQUIRE(internal::spec::spec_defects(spec).empty());
  const std::function<void(const ParameterSpec&)> check = [&](const ParameterSpec& parameter) {
    INFO(parameter.name);
    REQUIRE((!parameter.text.empty() || parameter.name == "segment"));
    if (parameter.type == ParameterType::number || parameter.type == ParameterType::vector)
      REQUIRE(static_cast<bool>(parse_unit(parameter.unit)));
    for (const auto& member : parameter.members) check(member);
  };
  for (const auto& parameter : spec.parameters) check(parameter);

  Drive drive(Json::parse(spec.example));
  for (const auto& channel : drive.channels())
    for (const auto& field : channel.fields) {
      INFO(channel.name << "." << field.name);
      REQUIRE(!field.text.empty());
      REQUIRE(static_cast<bool>(parse_unit(field.unit)));
    }
  REQUIRE(drive.rest().size() > 1000);
}

}  // namespace vehicle_simulator_test
