// SPDX-License-Identifier: Apache-2.0
// The vehicle simulator: its trajectory against other mathematics, its errors against their statistics, its
// manners.
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/testing.hpp"
#include "binnacle/unit.hpp"
#include "catch.hpp"
#include "config/document.hpp"
#include "spec/check.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"
#include "vehicle_simulator/simulator.hpp"

using namespace binnacle;
using namespace binnacle::vehicle_simulator;
using Eigen::Vector3d;

namespace {

using Json = nlohmann::ordered_json;
constexpr double degree = std::numbers::pi / 180.0;

// ---- parameters from JSON, checked by the kernel

ParameterValue checked(const Json& config) {
  Diagnostics diagnostics;
  const auto document = config::Document::parse(config.dump(), "test.json", {}, diagnostics);
  ParameterValue value =
      spec::Reader(document, diagnostics).parameters(VehicleSimulator::spec().parameters, "vehicle_simulator");
  INFO(diagnostics.text());
  REQUIRE(diagnostics.empty());
  return value;
}

// ---- running it

struct Quiet final : Reporter {
  void warn(const std::string&, const std::string&, int, const std::string&) override {}
};

struct Emitted {
  int channel;
  Time t, t0;
  std::vector<double> fields;
  std::vector<double> covariance;

  bool operator==(const Emitted& other) const {
    return channel == other.channel && t == other.t && t0 == other.t0 && fields == other.fields &&
           covariance == other.covariance;
  }
  Vector3d triple(std::size_t first) const { return {fields[first], fields[first + 1], fields[first + 2]}; }
};

class Drive {
 public:
  explicit Drive(const Json& config, std::uint64_t seed = 1) {
    const ParameterValue parameters = checked(config);
    source_ = std::make_shared<VehicleSimulator>(Binding("drive", Parameters(parameters), {}, {}));
    Quiet quiet;
    source_->open(quiet);
    restart(seed);
  }

  void restart(std::uint64_t seed) { memory_ = binnacle::testing::SourceCaller(*source_).fresh_memory(seed); }

  std::optional<Emitted> next() {
    const auto next = binnacle::testing::SourceCaller(*source_).next(memory_.data());
    REQUIRE(next.damage.empty());
    if (next.status == SourceStatus::end) return std::nullopt;
    return Emitted{next.sample.channel, next.sample.t, next.sample.t0, next.sample.fields, next.sample.covariance};
  }

  std::vector<Emitted> rest() {
    std::vector<Emitted> all;
    while (auto sample = next()) all.push_back(std::move(*sample));
    return all;
  }

  std::vector<Emitted> of(int channel) {
    std::vector<Emitted> chosen;
    while (auto sample = next())
      if (sample->channel == channel) chosen.push_back(std::move(*sample));
    return chosen;
  }

  std::vector<std::byte>& memory() { return memory_; }
  const std::vector<ChannelDeclaration>& channels() const { return source_->declaration().channels; }

 private:
  std::shared_ptr<VehicleSimulator> source_;
  std::vector<std::byte> memory_;
};

Trajectory trajectory_of(const Json& config) {
  const ParameterValue value = checked(config);
  const Parameters p(value);
  const Parameters start = p.object("start");
  return Trajectory({{start.number("lat"), start.number("lon"), start.number("height")}}, read_segments(p),
                    {p.number("roll_gradient"), p.number("pitch_gradient")});
}

// ---- drives

const Json munich = {{"lat", "48.1 deg"}, {"lon", "11.6 deg"}, {"height", "520 m"}, {"heading", "30 deg"}};

Json lively_segments() {
  return Json::parse(R"([
    {"do": "still", "duration": "6 s"},
    {"do": "accelerate", "to": "14 m/s", "acceleration": "1.8 m/s^2"},
    {"do": "turn", "angle": "95 deg", "rate": "15 deg/s"},
    {"do": "straight", "duration": "5 s"},
    {"do": "climb", "height": "6 m", "duration": "12 s"},
    {"do": "turn", "angle": "-200 deg", "duration": "14 s"},
    {"do": "accelerate", "to": "22 m/s", "duration": "9 s"},
    {"do": "climb", "slope": "-4 deg", "duration": "7 s"},
    {"do": "accelerate", "to": 0, "acceleration": "-2.5 m/s^2"},
    {"do": "still", "duration": "3 s"}])");
}

Json lively_drive(int repeat) {
  return {{"start", munich},
          {"segments", lively_segments()},
          {"repeat", repeat},
          {"perfect", true},
          {"roll_gradient", "4 deg/g"},
          {"pitch_gradient", "1.5 deg/g"},
          {"gnss_rate", 1},
          {"truth_rate", 1}};
}

Json standing(double seconds_long) {
  return {{"start", munich}, {"segments", Json::array({{{"do", "still"}, {"duration", seconds_long}}})}};
}

double metres(const Vector3d& lla, const Vector3d& from) { return strapdown::position_minus(lla, from).norm(); }

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
    const Inertial before = inertial(trajectory.motion(t - 1e-7)), after = inertial(trajectory.motion(t + 1e-7));
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
    REQUIRE((inertial(now).omega_ib_b - omega_ib_b).norm() < 1e-6);
  }
}

TEST_CASE("manoeuvres end where they are specified to") {
  const auto config = lively_drive(1);
  const Trajectory trajectory = trajectory_of(config);
  const ParameterValue value = checked(config);
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

// ---- the statistics of the errors

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
  REQUIRE(spec::spec_defects(spec).empty());
  const std::function<void(const ParameterSpec&)> check = [&](const ParameterSpec& parameter) {
    INFO(parameter.name);
    REQUIRE((!parameter.text.empty() || parameter.name == "segment"));
    if (parameter.type == ParameterType::number || parameter.type == ParameterType::vector)
      REQUIRE(static_cast<bool>(read_unit(parameter.unit)));
    for (const auto& member : parameter.members) check(member);
  };
  for (const auto& parameter : spec.parameters) check(parameter);

  Drive drive(Json::parse(spec.example));
  for (const auto& channel : drive.channels())
    for (const auto& field : channel.fields) {
      INFO(channel.name << "." << field.name);
      REQUIRE(!field.text.empty());
      REQUIRE(static_cast<bool>(read_unit(field.unit)));
    }
  REQUIRE(drive.rest().size() > 1000);
}
