// SPDX-License-Identifier: Apache-2.0
// The source: a ship in waves as samples of a master INS, of a slave's inertial sensors, and truth.
#include "simulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "random/normal.hpp"
#include "simulation/quadrature.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::ship_simulator {

using Eigen::Vector3d;
using Eigen::Vector4d;
using simulation::first_normal_vector;
using simulation::Inertial;
using simulation::normal_vector;
using simulation::SensorModel;
using simulation::SensorState;

namespace {

using ConstVector = Eigen::Map<const Vector3d>;
using Vector = Eigen::Map<Vector3d>;
using ConstQuaternion = Eigen::Map<const Vector4d>;
using Quaternion = Eigen::Map<Vector4d>;

/// Two Gauss–Legendre points on pieces of this many radians of the fastest tone leave (0.03)⁴/4320 = 2e-10 of the tone.
constexpr double widest_piece = 0.03;

Course read_course(const Parameters& p) {
  return {{p.number("lat"), p.number("lon"), p.number("height")},
          p.number("speed"),
          p.number("heading"),
          p.number("roll"),
          p.number("pitch")};
}

std::array<std::vector<Tone>, freedoms> read_motion(const Parameters& p) {
  std::array<std::vector<Tone>, freedoms> tones;
  for (std::size_t k = 0; k < freedoms; ++k)
    tones[k] = read_freedom(p.object(freedom_name[k]), std::string("/motion/") + freedom_name[k]);
  return tones;
}

SensorModel read_sensor(const Parameters& p, bool is_perfect) {
  SensorModel model;
  if (is_perfect) return model;
  model.bias = p.vector("bias");
  model.scale = p.vector("scale");
  model.misalignment = p.number("misalignment");
  model.noise = std::sqrt(p.number("noise_time")) * Vector3d(p.vector("noise"));
  return model;
}

MinsModel read_mins(const Parameters& p, bool is_perfect) {
  if (is_perfect) return {};
  const double scale = p.number("noise_scale");
  return {.velocity_noise = scale * Vector3d(p.vector("velocity_noise")),
          .velocity_bias = p.vector("velocity_bias"),
          .attitude_noise = scale * Vector3d(p.vector("attitude_noise")),
          .attitude_bias = p.vector("attitude_bias"),
          .position_noise = scale * Vector3d(p.vector("position_noise")),
          .position_bias = p.vector("position_bias")};
}

MountingModel read_mounting(const Parameters& p) {
  const Eigen::Matrix3d nominal = p.matrix("nominal");
  if (!((nominal * nominal.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-9) ||
      nominal.determinant() < 0.0)
    throw ComponentError("the nominal mounting is not a rotation", "/mounting/nominal");
  const bool is_given = p.has("misalignment");
  return {strapdown::quaternion_from_dcm(nominal), is_given ? Vector3d(p.vector("misalignment")) : Vector3d::Zero(),
          is_given ? Vector3d::Zero() : Vector3d(p.vector("misalignment_sigma")), p.vector("lever_arm")};
}

Eigen::Matrix<double, 9, 1> read_triple(const Parameters& p) {
  Eigen::Matrix<double, 9, 1> all;
  all << p.vector("position"), p.vector("velocity"), p.vector("attitude");
  return all;
}

InitialModel read_initial(const Parameters& p, bool is_perfect) {
  return {p.text("from") == "mins", (is_perfect ? 0.0 : 1.0) * read_triple(p.object("error")),
          read_triple(p.object("sigma"))};
}

double uniform_phase(random::Philox& stream) {
  return 2.0 * std::numbers::pi * 0x1p-53 * static_cast<double>(stream() >> 11);
}

}  // namespace

/// All that changes while the source runs, and what is drawn once a run: plain memory in the kernel's arena.
struct ShipSimulator::Memory {
  std::uint64_t seed;
  std::int64_t next_imu, next_mins, next_truth, next_mounting;  // ticks of their clocks
  std::int64_t has_initial;                                     // the initial estimate is still to be emitted
  SensorState gyro, accel;
  random::Philox velocity_stream, attitude_stream, position_stream;
  double velocity_bias[3], attitude_bias[3], position_bias[3];
  double misalignment[3];
  double q_ms[4];  // SINS axes to MINS axes
  double q_im[4];  // at the end of the last IMU interval
};

ShipSimulator::ShipSimulator(const Binding& binding) : ShipSimulator(binding.parameters()) {}

ShipSimulator::ShipSimulator(const Parameters& p)
    : motion_(read_course(p.object("start")), read_motion(p.object("motion"))),
      start_time_(p.time("start_time")),
      duration_(p.time("duration")),
      imu_clock_(p.number("imu_rate")),
      mins_clock_(p.object("mins").number("rate")),
      truth_clock_(p.number("truth_rate")),
      has_rotation_vectors_(p.text("increments") == "rotation_vector"),
      gyro_(read_sensor(p.object("gyro"), p.boolean("perfect"))),
      accel_(read_sensor(p.object("accel"), p.boolean("perfect"))),
      mins_(read_mins(p.object("mins"), p.boolean("perfect"))),
      mounting_(read_mounting(p.object("mounting"))),
      initial_(read_initial(p.object("initial"), p.boolean("perfect"))),
      longest_piece_(widest_piece / std::max(motion_.largest_omega(), 1e-3)),
      channels_(declare_channels(declaration_, imu_clock_.at(1) + 1)),
      memory_(declaration_.keeps<Memory>()),
      phases_(declaration_.keeps_array<double>(motion_.tone_count())) {
  const double reach = p.object("start").number("speed") * seconds(duration_);
  if (reach > 1e6)
    throw ComponentError("the ship would go further than 1000 km, where its course is no longer what was specified",
                         "/duration");
}

ComponentSpec ShipSimulator::spec() { return declare_component(); }

void ShipSimulator::initialise(std::uint64_t seed, const MemoryView& bytes) const {
  const double dt = imu_clock_.interval_before(1);
  Memory& memory = bytes[memory_];
  memory.seed = seed;
  memory.next_imu = 1;
  memory.next_mins = 1;
  memory.has_initial = 1;
  memory.gyro = simulation::start(gyro_, "gyro", seed, dt);
  memory.accel = simulation::start(accel_, "accel", seed, dt);
  memory.velocity_stream = random::stream(seed, "mins.velocity");
  memory.attitude_stream = random::stream(seed, "mins.attitude");
  memory.position_stream = random::stream(seed, "mins.position");
  Vector(memory.velocity_bias) = mins_.velocity_bias.cwiseProduct(first_normal_vector(seed, "mins.velocity_bias"));
  Vector(memory.attitude_bias) = mins_.attitude_bias.cwiseProduct(first_normal_vector(seed, "mins.attitude_bias"));
  Vector(memory.position_bias) = mins_.position_bias.cwiseProduct(first_normal_vector(seed, "mins.position_bias"));
  const Vector3d misalignment =
      mounting_.misalignment + mounting_.sigma.cwiseProduct(first_normal_vector(seed, "mounting"));
  Vector(memory.misalignment) = misalignment;
  Quaternion(memory.q_ms) = strapdown::attitude_plus(mounting_.nominal, misalignment);

  double* const phases = bytes[phases_].data();
  std::size_t i = 0;
  for (std::size_t k = 0; k < freedoms; ++k) {
    auto stream = random::stream(seed, std::string("motion.") + freedom_name[k]);
    for (const Tone& tone : motion_.tones()[k]) {
      const double drawn = uniform_phase(stream);
      phases[i++] = std::isnan(tone.phase) ? drawn : tone.phase;
    }
  }
  if (has_rotation_vectors_) Quaternion(memory.q_im) = inertial_attitude(motion_.at(0.0, phases), 0.0);
}

SourceStatus ShipSimulator::next(const MemoryView& bytes, SourceOutput& out) const {
  Memory& memory = bytes[memory_];
  const double* const phases = bytes[phases_].data();
  const Time truth_due = truth_clock_.due(memory.next_truth, duration_);
  const Time mounting_due = truth_clock_.due(memory.next_mounting, duration_);
  const Time imu_due = imu_clock_.due(memory.next_imu, duration_);
  const Time mins_due = mins_clock_.due(memory.next_mins, duration_);
  const Time first = std::min({truth_due, mounting_due, imu_due, mins_due});

  if (memory.has_initial != 0) {
    emit_initial(memory, phases, out.on(channels_.initial.channel));
  } else if (first == simulation::never) {
    return SourceStatus::end;
  } else if (first == truth_due) {
    emit_truth(memory, phases, out.on(channels_.truth.channel));
  } else if (first == mounting_due) {
    emit_mounting(memory, out.on(channels_.mounting.channel));
  } else if (first == imu_due) {
    emit_imu(memory, phases, out.on(channels_.imu.channel));
  } else {
    emit_mins(memory, phases, out.on(channels_.mins.channel));
  }
  return SourceStatus::sample;
}

/// ∫ ω dt and ∫ f dt over [t0, t1] in ship axes.
Inertial ShipSimulator::increments(double t0, double t1, const double* phases) const {
  const auto pieces = static_cast<int>(std::ceil((t1 - t0) / longest_piece_));
  const double half = 0.5 * (t1 - t0) / pieces;
  Inertial sum{Vector3d::Zero(), Vector3d::Zero()};
  for (int i = 0; i < pieces; ++i) {
    const double middle = t0 + (2 * i + 1) * half;
    for (const State& state : motion_.around(middle, half * simulation::Gauss2::node[1], phases)) {
      const Inertial now = inertial_at_lever_arm(state, mounting_.lever_arm);
      sum.omega_ib_b += half * now.omega_ib_b;
      sum.f_b += half * now.f_b;
    }
  }
  return sum;
}

/// The rotation vector from `last` to the attitude at t, in ship axes; `last` becomes t.
Vector3d ShipSimulator::rotation_since(Vector4d& last, double t, const double* phases) const {
  const Vector4d now = inertial_attitude(motion_.at(t, phases), t);
  Vector4d turn = strapdown::quaternion_product(strapdown::quaternion_conjugate(last), now);
  if (turn[0] < 0.0) turn = -turn;
  last = now;
  return strapdown::quaternion_log(turn);
}

void ShipSimulator::emit_imu(Memory& memory, const double* phases, SampleWriter& out) const {
  const std::int64_t tick = memory.next_imu++;
  const Time begin = imu_clock_.at(tick - 1), end = imu_clock_.at(tick);
  const double dt = seconds(end - begin);
  Inertial exact = increments(seconds(begin), seconds(end), phases);
  if (has_rotation_vectors_) {
    Vector4d last = ConstQuaternion(memory.q_im);
    exact.omega_ib_b = rotation_since(last, seconds(end), phases);
    Quaternion(memory.q_im) = last;
  }
  const Eigen::Matrix3d C_sm = strapdown::dcm_from_quaternion(ConstQuaternion(memory.q_ms)).transpose();
  out.t0 = start_time_ + begin;
  out.t = start_time_ + end;
  out[channels_.imu.w] = measured(gyro_, memory.gyro, C_sm * exact.omega_ib_b, dt);
  out[channels_.imu.f] = measured(accel_, memory.accel, C_sm * exact.f_b, dt);
}

void ShipSimulator::emit_mins(Memory& memory, const double* phases, SampleWriter& out) const {
  const Time t = mins_clock_.at(memory.next_mins++);
  const simulation::Motion m = motion(motion_.at(seconds(t), phases));
  const auto error = [](const Vector3d& sigma, random::Philox& stream, const double* bias) -> Vector3d {
    return ConstVector(bias) + sigma.cwiseProduct(normal_vector(stream));
  };
  out.t = start_time_ + t;
  const auto& to = channels_.mins;
  out[to.velocity] = m.v_n + error(mins_.velocity_noise, memory.velocity_stream, memory.velocity_bias);
  out[to.position] =
      strapdown::position_plus(m.lla, error(mins_.position_noise, memory.position_stream, memory.position_bias));
  out[to.attitude] = m.roll_pitch_yaw + error(mins_.attitude_noise, memory.attitude_stream, memory.attitude_bias);
}

void ShipSimulator::emit_truth(Memory& memory, const double* phases, SampleWriter& out) const {
  const Time t = truth_clock_.at(memory.next_truth++);
  const Point point = at_lever_arm(motion_.at(seconds(t), phases), mounting_.lever_arm);
  const Vector4d q_ns = strapdown::quaternion_product(point.q_nm, ConstQuaternion(memory.q_ms));
  const Vector4d level = strapdown::quaternion_product(q_ns, strapdown::quaternion_conjugate(mounting_.nominal));
  out.t = start_time_ + t;
  const auto& to = channels_.truth;
  out[to.position] = point.lla;
  out[to.velocity] = point.v_n;
  out[to.attitude] = strapdown::euler_from_quaternion(q_ns);
  out[to.level_attitude] = strapdown::euler_from_quaternion(level);
}

void ShipSimulator::emit_mounting(Memory& memory, SampleWriter& out) const {
  out.t = start_time_ + truth_clock_.at(memory.next_mounting++);
  out[channels_.mounting.misalignment] = ConstVector(memory.misalignment);
}

// From the truth: truth = estimate ⊞ δ with δ ~ N(0, error²). From the MINS: what it shows at the start, as if the SINS
// were mounted as designed; the attitude is then wrong by the misalignment.
void ShipSimulator::emit_initial(Memory& memory, const double* phases, SampleWriter& out) const {
  memory.has_initial = 0;
  const State state = motion_.at(0.0, phases);
  const Point point = at_lever_arm(state, mounting_.lever_arm);
  const Vector3d w_position = first_normal_vector(memory.seed, "initial.position");
  const Vector3d w_velocity = first_normal_vector(memory.seed, "initial.velocity");
  const Vector3d w_attitude = first_normal_vector(memory.seed, "initial.attitude");
  Vector3d position_error, velocity_error;
  Vector4d level;
  if (initial_.is_from_mins) {
    position_error = ConstVector(memory.position_bias) + mins_.position_noise.cwiseProduct(w_position);
    velocity_error = ConstVector(memory.velocity_bias) + mins_.velocity_noise.cwiseProduct(w_velocity);
    level = strapdown::quaternion_from_euler(state.euler + ConstVector(memory.attitude_bias) +
                                             mins_.attitude_noise.cwiseProduct(w_attitude));
  } else {
    position_error = -initial_.error.head<3>().cwiseProduct(w_position);
    velocity_error = -initial_.error.segment<3>(3).cwiseProduct(w_velocity);
    const Vector4d q_ns =
        strapdown::attitude_plus(strapdown::quaternion_product(point.q_nm, ConstQuaternion(memory.q_ms)),
                                 -initial_.error.tail<3>().cwiseProduct(w_attitude));
    level = strapdown::quaternion_product(q_ns, strapdown::quaternion_conjugate(mounting_.nominal));
  }
  out.t = start_time_;
  const auto& to = channels_.initial;
  out[to.position] = strapdown::position_plus(point.lla, position_error);
  out[to.velocity] = point.v_n + velocity_error;
  out[to.attitude] = strapdown::euler_from_quaternion(strapdown::quaternion_product(level, mounting_.nominal));
  out[to.level_attitude] = strapdown::euler_from_quaternion(level);
  out.attach_covariance().as<9, 9>() = initial_.sigma.cwiseAbs2().asDiagonal();
}

}  // namespace binnacle::ship_simulator
