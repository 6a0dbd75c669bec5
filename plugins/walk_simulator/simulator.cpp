// SPDX-License-Identifier: Apache-2.0
// The source: a walk as an inertial sensor on the foot measures it, truth, and an initial estimate.
#include "simulator.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::walk_simulator {

using Eigen::Vector3d;
using simulation::never;

namespace {

constexpr double degree = std::numbers::pi / 180.0;

std::vector<ParameterSpec> gait_members() {
  using namespace parameter;
  return {
      number("stride", "m")
          .above(0)
          .at_most(4)
          .defaults("1.4")
          .about("distance between two footprints of the same foot"),
      parameter::time("cycle")
          .at_least(0.2)
          .at_most(10)
          .defaults("\"1.1 s\"")
          .about("duration of a swing and the following stance"),
      number("stance", "1")
          .at_least(0.05)
          .at_most(0.9)
          .defaults("0.4")
          .about("fraction of the cycle in which the foot stands"),
      number("lift", "m").at_least(0).at_most(1).defaults("0.12").about("height of the foot in mid-swing"),
      number("outward", "m").at_least(-1).at_most(1).defaults("0.03").about("displacement to the right in mid-swing"),
      number("toe_off", "rad")
          .at_least(0)
          .at_most(80 * degree)
          .defaults("\"60 deg\"")
          .about("pitch with toes down, early in the swing"),
      number("heel_strike", "rad")
          .at_least(0)
          .at_most(80 * degree)
          .defaults("\"25 deg\"")
          .about("pitch with toes up, late in the swing"),
  };
}

std::vector<ParameterSpec> leg_members() {
  using namespace parameter;
  return {
      choice("do", {"stand", "walk"}).required().about("type of the leg"),
      parameter::time("duration").above(0).at_most(1e5).about("duration of 'stand'"),
      integer("strides").at_least(1).at_most(100000).about("number of strides of 'walk'"),
      number("turn", "rad").about("change of heading over all strides of 'walk', positive to the right"),
      number("climb", "m").about("change of height over all strides of 'walk'"),
  };
}

std::vector<ParameterSpec> start_members() {
  using namespace parameter;
  return {
      number("lat", "rad").at_least(-85.0 * degree).at_most(85.0 * degree).required().about("geodetic latitude"),
      number("lon", "rad").defaults("0").about("longitude"),
      number("height", "m").at_least(-1e4).at_most(1e5).defaults("0").about("height above the ellipsoid"),
      number("heading", "rad").defaults("0").about("heading, clockwise from north"),
  };
}

std::vector<ParameterSpec> initial_members() {
  using namespace parameter;
  return {
      vector("position", "m", 3).at_least(0).defaults("0.01").about("position error: north, east, down"),
      vector("velocity", "m/s", 3).at_least(0).defaults("0.001").about("velocity error: north, east, down"),
      number("tilt", "rad").at_least(0).defaults("\"0.1 deg\"").about("attitude error about north and about east"),
      number("heading", "rad").at_least(0).defaults("\"1 deg\"").about("attitude error about down"),
  };
}

Leg read_leg(const Parameters& parameters, std::size_t index) {
  const std::string& kind = parameters.text("do");
  const std::string at = "/legs/" + std::to_string(index);
  for (const char* name : {"duration", "strides", "turn", "climb"}) {
    const bool is_of_stand = std::string(name) == "duration";
    if (parameters.has(name) && is_of_stand != (kind == "stand"))
      throw ComponentError("'" + kind + "' does not take '" + name + "'", at + "/" + name);
  }
  const char* const needed = kind == "stand" ? "duration" : "strides";
  if (!parameters.has(needed)) throw ComponentError("'" + kind + "' needs '" + needed + "'", at);
  Leg leg;
  if (kind == "stand") {
    leg.duration = seconds(parameters.time("duration"));
    return leg;
  }
  leg.strides = static_cast<int>(parameters.integer("strides"));
  leg.turn = parameters.has("turn") ? parameters.number("turn") : 0.0;
  leg.climb = parameters.has("climb") ? parameters.number("climb") : 0.0;
  return leg;
}

std::unique_ptr<const Walk> read_walk(const Parameters& parameters) {
  const Parameters start = parameters.object("start"), of_gait = parameters.object("gait");
  Gait gait;
  gait.stride = of_gait.number("stride");
  gait.cycle = seconds(of_gait.time("cycle"));
  gait.swing = gait.cycle * (1.0 - of_gait.number("stance"));
  gait.lift = of_gait.number("lift");
  gait.outward = of_gait.number("outward");
  gait.toe_off = of_gait.number("toe_off");
  gait.heel_strike = of_gait.number("heel_strike");
  std::vector<Leg> legs;
  for (std::int64_t pass = 0; pass < parameters.integer("repeat"); ++pass) {
    std::size_t index = 0;
    for (const ParameterValue& value : parameters.list("legs")) legs.push_back(read_leg(Parameters(value), index++));
  }
  return std::make_unique<const Walk>(Vector3d(start.number("lat"), start.number("lon"), start.number("height")),
                                      start.number("heading"), gait, legs);
}

simulation::SensorModel read_sensor_unless(bool is_perfect, const Parameters& parameters) {
  return is_perfect ? simulation::SensorModel{} : simulation::read_sensor(parameters);
}

}  // namespace

/// All that changes while the source runs: plain memory in the kernel's arena.
struct WalkSimulator::Memory {
  std::uint64_t seed;
  std::int64_t next_imu, next_truth, has_initial;
  simulation::SensorState gyro, accel;
};

ComponentSpec WalkSimulator::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "walk_simulator";
  spec.summary = "A walk: samples of an inertial sensor on one foot, truth and an initial estimate.";
  spec.source =
      "I. Skog, P. Händel, J.-O. Nilsson, J. Rantakokko, Zero-velocity detection: an algorithm evaluation, IEEE Trans. "
      "Biomed. Eng. 57 (2010), for what a foot does; Groves (5.53), (5.41) for what the sensor measures";
  spec.parameters = {
      object("start", start_members()).required().about("initial position and heading of the foot"),
      parameter::time("start_time").defaults("0").about("start time on the run's clock"),
      list("legs", object("leg", leg_members())).required().about("sequence of legs"),
      integer("repeat").at_least(1).at_most(10000).defaults("1").about("number of times the list of legs is walked"),
      object("gait", gait_members()).defaults("{}").about("gait of the foot"),
      number("imu_rate", "Hz").at_least(20).at_most(1e4).defaults("200").about("sample rate of the channel imu"),
      choice("imu_kind", {"increment", "rate"})
          .defaults("\"increment\"")
          .about("content of imu: integrals over the interval, or means"),
      number("truth_rate", "Hz")
          .at_least(0)
          .at_most(1e4)
          .defaults("20")
          .about("rate of truth samples, the first at the start; 0: none"),
      boolean("perfect").defaults("false").about("true: no errors; the reported covariance does not change"),
      object("gyro", simulation::sensor_members("rad/s", "rad/sqrt(s)",
                                                {"\"100 deg/h\"", "\"5 deg/h\"", "\"300 s\"", "\"0.3 deg/sqrt(h)\"",
                                                 "\"300 ppm\""}))
          .defaults("{}")
          .about("errors of the gyroscopes"),
      object("accel", simulation::sensor_members("m/s^2", "m/s/sqrt(s)",
                                                 {"\"3 mg\"", "\"0.05 mg\"", "\"300 s\"", "\"0.03 m/s/sqrt(h)\"",
                                                  "\"300 ppm\""}))
          .defaults("{}")
          .about("errors of the accelerometers"),
      object("initial_sigma", initial_members())
          .defaults("{}")
          .about("standard deviations of the estimate on the channel initial, from which its errors are drawn"),
  };
  spec.example = R"json({"start": {"lat": "59.35 deg", "lon": "18.07 deg"},
    "legs": [{"do": "stand", "duration": "5 s"}, {"do": "walk", "strides": 10, "turn": "90 deg"}]})json";
  return spec;
}

WalkSimulator::WalkSimulator(const Binding& binding) : WalkSimulator(binding.parameters()) {}

WalkSimulator::WalkSimulator(const Parameters& parameters)
    : walk_(read_walk(parameters)),
      start_time_(parameters.time("start_time")),
      end_(nanoseconds(walk_->duration())),
      imu_clock_(parameters.number("imu_rate")),
      truth_clock_(parameters.number("truth_rate")),
      emits_rates_(parameters.text("imu_kind") == "rate"),
      is_perfect_(parameters.boolean("perfect")),
      gyro_(read_sensor_unless(is_perfect_, parameters.object("gyro"))),
      accel_(read_sensor_unless(is_perfect_, parameters.object("accel"))),
      memory_(declaration_.keeps<Memory>()) {
  const Parameters sigmas = parameters.object("initial_sigma");
  const double tilt = sigmas.number("tilt");
  sigma_ << sigmas.vector("position"), sigmas.vector("velocity"), tilt, tilt, sigmas.number("heading");
  declare_channels();
}

void WalkSimulator::declare_channels() {
  using namespace simulation;
  ChannelDeclaration of_imu("imu"), of_truth("truth"), of_initial("initial");
  imu_ = carry_imu(of_imu, emits_rates_);
  of_imu.max_interval = imu_clock_.at(1) + 1;
  position_ = of_truth.carries(position_fields());
  velocity_ = of_truth.carries(velocity_fields());
  attitude_ = of_truth.carries(attitude_fields());
  gyro_bias_ = of_truth.carries(triad("bg", "rad/s", "bias of the gyroscopes"));
  accel_bias_ = of_truth.carries(triad("ba", "m/s^2", "bias of the accelerometers"));
  standing_ = of_truth.carries(level("standing", "1", "1 in a stance, 0 in a swing"));
  initial_position_ = of_initial.carries(position_fields());
  initial_velocity_ = of_initial.carries(velocity_fields());
  initial_attitude_ = of_initial.carries(attitude_fields());
  of_initial.covariance = navigation_covariance();
  imu_channel_ = declaration_.emits(std::move(of_imu));
  truth_channel_ = declaration_.emits(std::move(of_truth));
  initial_channel_ = declaration_.emits(std::move(of_initial));
}

void WalkSimulator::initialise(std::uint64_t seed, const MemoryView& bytes) const {
  const double dt = imu_clock_.interval_before(1);
  bytes[memory_] = Memory{.seed = seed,
                          .next_imu = 1,
                          .next_truth = 0,
                          .has_initial = 1,
                          .gyro = simulation::start(gyro_, "gyro", seed, dt),
                          .accel = simulation::start(accel_, "accel", seed, dt)};
}

SourceStatus WalkSimulator::next(const MemoryView& bytes, SourceOutput& out) const {
  Memory& memory = bytes[memory_];
  const Time truth_due = truth_clock_.due(memory.next_truth, end_), imu_due = imu_clock_.due(memory.next_imu, end_);
  if (memory.has_initial != 0)
    emit_initial(memory, out.on(initial_channel_));
  else if (std::min(truth_due, imu_due) == never)
    return SourceStatus::end;
  else if (truth_due <= imu_due)
    emit_truth(memory, out.on(truth_channel_));
  else
    emit_imu(memory, out.on(imu_channel_));
  return SourceStatus::sample;
}

void WalkSimulator::emit_imu(Memory& memory, SampleWriter& out) const {
  const std::int64_t tick = memory.next_imu++;
  const double dt = imu_clock_.interval_before(tick);
  const simulation::Inertial exact = walk_->increments(seconds(imu_clock_.at(tick - 1)), seconds(imu_clock_.at(tick)));
  const double unit = emits_rates_ ? 1.0 / dt : 1.0;
  out.t0 = start_time_ + imu_clock_.at(tick - 1);
  out.t = start_time_ + imu_clock_.at(tick);
  out[imu_.w] = unit * measured(gyro_, memory.gyro, exact.omega_ib_b, dt);
  out[imu_.f] = unit * measured(accel_, memory.accel, exact.f_b, dt);
  const double next_dt = imu_clock_.interval_before(tick + 1);
  advance(gyro_, memory.gyro, next_dt);
  advance(accel_, memory.accel, next_dt);
}

void WalkSimulator::emit_truth(Memory& memory, SampleWriter& out) const {
  const Time t = truth_clock_.at(memory.next_truth++);
  const simulation::Motion motion = walk_->motion(seconds(t));
  const Time interval_begin = imu_clock_.at(memory.next_imu - 1);
  const double fraction = seconds(t - interval_begin) / imu_clock_.interval_before(memory.next_imu);
  out.t = start_time_ + t;
  out[position_] = motion.lla;
  out[velocity_] = motion.v_n;
  out[attitude_] = motion.roll_pitch_yaw;
  out[gyro_bias_] = simulation::bias_at(memory.gyro, fraction);
  out[accel_bias_] = simulation::bias_at(memory.accel, fraction);
  out[standing_] = walk_->is_standing(seconds(t)) ? 1.0 : 0.0;
}

// The estimate is drawn so that truth = estimate ⊞ δ with δ ~ N(0, P₀), P₀ = diag(sigma²).
void WalkSimulator::emit_initial(Memory& memory, SampleWriter& out) const {
  memory.has_initial = 0;
  const simulation::Motion motion = walk_->motion(0.0);
  const auto delta = [&](int group, const char* name) -> Vector3d {
    const Vector3d w = simulation::first_normal_vector(memory.seed, name);
    return (is_perfect_ ? 0.0 : 1.0) * sigma_.segment<3>(3 * group).cwiseProduct(w);
  };
  const Eigen::Vector4d q_nb = strapdown::quaternion_from_euler(motion.roll_pitch_yaw);
  out.t = start_time_;
  out[initial_position_] = strapdown::position_plus(motion.lla, -delta(0, "initial.position"));
  out[initial_velocity_] = motion.v_n - delta(1, "initial.velocity");
  out[initial_attitude_] =
      strapdown::euler_from_quaternion(strapdown::attitude_plus(q_nb, -delta(2, "initial.attitude")));
  out.attach_covariance().as<9, 9>() = sigma_.cwiseAbs2().asDiagonal();
}

}  // namespace binnacle::walk_simulator
