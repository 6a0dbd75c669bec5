// SPDX-License-Identifier: Apache-2.0
// The source: a drive along segments as IMU samples, GNSS fixes, truth, and an initial estimate.
#include "simulator.hpp"

#include <algorithm>
#include <numbers>

#include <Eigen/Geometry>

#include "body_parameters.hpp"
#include "random/normal.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::vehicle_simulator {

using simulation::never;
using simulation::normal_vector;
using simulation::SensorModel;
using simulation::SensorState;

namespace {

constexpr double nearest_to_pole = 89.5 * std::numbers::pi / 180.0;

Eigen::Vector3d antenna_velocity(const ImuMotion& motion, const Eigen::Matrix3d& C_nb,
                                 const Eigen::Vector3d& lever_arm_b) {
  const Eigen::Vector3d omega_ie_b = C_nb.transpose() * strapdown::omega_ie_n(motion.lla[0]);
  const Eigen::Vector3d omega_eb_b = motion.omega_ib_b - omega_ie_b;
  return motion.v_n + C_nb * omega_eb_b.cross(lever_arm_b);
}

GnssModel read_gnss(const Parameters& parameters, bool is_perfect) {
  const Eigen::Vector3d position = parameters.vector("position_sigma");
  const Eigen::Vector3d velocity = parameters.vector("velocity_sigma");
  const auto reported = [&](std::string_view name, const Eigen::Vector3d& otherwise) -> Eigen::Vector3d {
    return parameters.has(name) ? Eigen::Vector3d(parameters.vector(name)) : otherwise;
  };
  const double error = is_perfect ? 0.0 : 1.0;
  return {error * position, error * velocity, reported("reported_position_sigma", position),
          reported("reported_velocity_sigma", velocity), parameters.vector("lever_arm")};
}

InitialModel read_initial(const Parameters& parameters, bool is_perfect) {
  InitialModel model;
  const double tilt = parameters.number("tilt");
  model.sigma << parameters.vector("position"), parameters.vector("velocity"), tilt, tilt, parameters.number("heading");
  model.is_perfect = is_perfect;
  return model;
}

SensorModel read_sensor_unless(bool is_perfect, const Parameters& parameters) {
  return is_perfect ? SensorModel{} : simulation::read_sensor(parameters);
}

Start read_start(const Parameters& parameters) {
  return {{parameters.number("lat"), parameters.number("lon"), parameters.number("height")}};
}

}  // namespace

/// All that changes while the source runs: plain memory in the kernel's arena.
struct VehicleSimulator::Memory {
  std::uint64_t seed;
  std::int64_t next_imu, next_gnss, next_truth;  // ticks of their clocks
  std::int64_t has_initial;                      // the initial estimate is still to be emitted
  SensorState gyro, accel;
  BodyMemory body;
  random::Philox position_stream, velocity_stream;
};

VehicleSimulator::VehicleSimulator(const Binding& binding) : VehicleSimulator(binding.parameters()) {}

VehicleSimulator::VehicleSimulator(const Parameters& parameters)
    : segments_(read_segments(parameters)),
      start_(read_start(parameters.object("start"))),
      suspension_{parameters.number("roll_gradient"), parameters.number("pitch_gradient")},
      body_(read_body(parameters), segments_),
      start_time_(parameters.time("start_time")),
      imu_clock_(parameters.number("imu_rate")),
      gnss_clock_(parameters.number("gnss_rate")),
      truth_clock_(parameters.number("truth_rate")),
      emits_rates_(parameters.text("imu_kind") == "rate"),
      gyro_(read_sensor_unless(parameters.boolean("perfect"), parameters.object("gyro"))),
      accel_(read_sensor_unless(parameters.boolean("perfect"), parameters.object("accel"))),
      gnss_(read_gnss(parameters.object("gnss"), parameters.boolean("perfect"))),
      initial_(read_initial(parameters.object("initial_sigma"), parameters.boolean("perfect"))),
      channels_(declare_channels(declaration_, emits_rates_, imu_clock_.at(1) + 1)),
      memory_(declaration_.keeps<Memory>()) {}

ComponentSpec VehicleSimulator::spec() { return declare_component(); }

void VehicleSimulator::open(Reporter&) {
  trajectory_ = std::make_unique<const Trajectory>(start_, segments_, suspension_);
  if (!(trajectory_->largest_latitude() < nearest_to_pole))
    throw ComponentError("the drive comes within 0.5 deg of a pole, where north and east are not defined",
                         "/start/lat");
}

void VehicleSimulator::initialise(std::uint64_t seed, const MemoryView& bytes) const {
  const double dt = imu_clock_.interval_before(1);
  bytes[memory_] = Memory{.seed = seed,
                          .next_imu = 1,
                          .next_gnss = 0,
                          .next_truth = 0,
                          .has_initial = 1,
                          .gyro = simulation::start(gyro_, "gyro", seed, dt),
                          .accel = simulation::start(accel_, "accel", seed, dt),
                          .body = body_.start(seed),
                          .position_stream = random::stream(seed, "gnss.position"),
                          .velocity_stream = random::stream(seed, "gnss.velocity")};
}

SourceStatus VehicleSimulator::next(const MemoryView& bytes, SourceOutput& out) const {
  Memory& memory = bytes[memory_];
  const Time end = trajectory_->duration();
  const Time truth_due = truth_clock_.due(memory.next_truth, end);
  const Time imu_due = imu_clock_.due(memory.next_imu, end);
  const Time gnss_due = gnss_clock_.due(memory.next_gnss, end);
  const Time first = std::min({truth_due, imu_due, gnss_due});

  if (memory.has_initial != 0) {
    emit_initial(memory, out.on(channels_.initial.channel));
  } else if (first == never) {
    return SourceStatus::end;
  } else if (first == truth_due) {
    emit_truth(memory, out.on(channels_.truth.channel));
  } else if (first == imu_due) {
    emit_imu(memory, out.on(channels_.imu.channel));
  } else {
    emit_gnss(memory, out.on(channels_.gnss.channel));
  }
  return SourceStatus::sample;
}

void VehicleSimulator::emit_imu(Memory& memory, SampleWriter& out) const {
  const std::int64_t tick = memory.next_imu++;
  const double dt = imu_clock_.interval_before(tick);
  const Inertial exact =
      body_.increments(*trajectory_, seconds(imu_clock_.at(tick - 1)), seconds(imu_clock_.at(tick)), memory.body);
  const double unit = emits_rates_ ? 1.0 / dt : 1.0;
  out.t0 = start_time_ + imu_clock_.at(tick - 1);
  out.t = start_time_ + imu_clock_.at(tick);
  out[channels_.imu.w] = unit * measured(gyro_, memory.gyro, exact.omega_ib_b, dt);
  out[channels_.imu.f] = unit * measured(accel_, memory.accel, exact.f_b, dt);
  const double next_dt = imu_clock_.interval_before(tick + 1);
  advance(gyro_, memory.gyro, next_dt);
  advance(accel_, memory.accel, next_dt);
}

void VehicleSimulator::emit_gnss(Memory& memory, SampleWriter& out) const {
  const Time t = gnss_clock_.at(memory.next_gnss++);
  const ImuMotion motion = body_.motion(*trajectory_, seconds(t), memory.body);
  const Eigen::Matrix3d C_nb = strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(motion.roll_pitch_yaw));
  const Eigen::Vector3d position_error = gnss_.position_error.cwiseProduct(normal_vector(memory.position_stream));
  const Eigen::Vector3d velocity_error = gnss_.velocity_error.cwiseProduct(normal_vector(memory.velocity_stream));
  out.t = start_time_ + t;
  const auto& to = channels_.gnss;
  out[to.position] = strapdown::position_plus(motion.lla, C_nb * gnss_.lever_arm_b + position_error);
  out[to.velocity] = antenna_velocity(motion, C_nb, gnss_.lever_arm_b) + velocity_error;
  out[to.position_sd] = gnss_.position_reported;
  out[to.velocity_sd] = gnss_.velocity_reported;
}

void VehicleSimulator::emit_truth(Memory& memory, SampleWriter& out) const {
  const Time t = truth_clock_.at(memory.next_truth++);
  const ImuMotion motion = body_.motion(*trajectory_, seconds(t), memory.body);
  const double speed = trajectory_->course(seconds(t)).speed;
  const Time interval_begin = imu_clock_.at(memory.next_imu - 1);
  const double fraction = seconds(t - interval_begin) / imu_clock_.interval_before(memory.next_imu);
  out.t = start_time_ + t;
  const auto& to = channels_.truth;
  out[to.position] = motion.lla;
  out[to.velocity] = motion.v_n;
  out[to.attitude] = motion.roll_pitch_yaw;
  out[to.gyro_bias] = bias_at(memory.gyro, fraction);
  out[to.accel_bias] = bias_at(memory.accel, fraction);
  out[to.gyro_scale] = Eigen::Vector3d(memory.gyro.scale);
  out[to.accel_scale] = Eigen::Vector3d(memory.accel.scale);
  out[to.misalignment] = Eigen::Vector3d(memory.body.misalignment);
  out[to.speed] = speed;
  out[to.standing] = speed == 0.0 ? 1.0 : 0.0;
  out[to.rates] = motion.omega_ib_b;
}

// The estimate is drawn so that truth = estimate ⊞ δ with δ ~ N(0, P₀), P₀ = diag(sigma²).
void VehicleSimulator::emit_initial(Memory& memory, SampleWriter& out) const {
  memory.has_initial = 0;
  const ImuMotion motion = body_.motion(*trajectory_, 0.0, memory.body);
  const auto delta = [&](int group, std::string_view name) -> Eigen::Vector3d {
    const Eigen::Vector3d w = simulation::first_normal_vector(memory.seed, name);
    return (initial_.is_perfect ? 0.0 : 1.0) * initial_.sigma.segment<3>(3 * group).cwiseProduct(w);
  };
  const Eigen::Vector4d q_nb = strapdown::quaternion_from_euler(motion.roll_pitch_yaw);
  out.t = start_time_;
  const auto& to = channels_.initial;
  out[to.position] = strapdown::position_plus(motion.lla, -delta(0, "initial.position"));
  out[to.velocity] = motion.v_n - delta(1, "initial.velocity");
  out[to.attitude] = strapdown::euler_from_quaternion(strapdown::attitude_plus(q_nb, -delta(2, "initial.attitude")));
  out.attach_covariance().as<9, 9>() = initial_.sigma.cwiseAbs2().asDiagonal();
}

}  // namespace binnacle::vehicle_simulator
