// SPDX-License-Identifier: Apache-2.0
#include "in_motion_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "strapdown/rotation.hpp"

namespace binnacle::in_motion_alignment {

namespace sd = strapdown;
using Eigen::Vector3d;

namespace {

constexpr Time longest_hole = nanoseconds_per_second / 10;  // between IMU samples
constexpr std::size_t few = 5;                              // velocities that go with a course

}  // namespace

struct State {
  Integrals integrals;  // from the last epoch to t_imu
  Time t_imu;
  double rate[3], specific_force[3];  // of the last IMU sample
  Window window;
  Time t_emitted;
  // for messages
  std::int64_t samples, velocities;
  double least_heading_sd, least_misfit;  // of fits; rad, and 1; 0: none yet

  void forget() {
    integrals = {};
    window.clear();
  }
};

ComponentSpec InMotionAlignment::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "in_motion_alignment";
  spec.summary =
      "attitude of a moving IMU from GNSS velocities over a window, for motion in any direction and without rest";
  spec.source =
      "Y. Wu, X. Pan, Velocity/position integration formula part I: application to in-flight coarse alignment, IEEE "
      "Transactions on Aerospace and Electronic Systems 49, 2013";
  std::vector<FieldSpec> of_imu, of_gnss;
  for (const char* name : {"wx", "wy", "wz"})
    of_imu.push_back(field::rate(name, "rad/s").about("mean over the sample, body axes"));
  for (const char* name : {"fx", "fy", "fz"})
    of_imu.push_back(field::rate(name, "m/s^2").about("mean over the sample, body axes"));
  for (const char* name : {"vn", "ve", "vd"})
    of_gnss.push_back(field::level(name, "m/s").about("velocity over ground"));
  for (const char* name : {"velocity_sd_n", "velocity_sd_e", "velocity_sd_d"})
    of_gnss.push_back(field::level(name, "m/s").optional().about("standard deviation of the velocity"));
  spec.inputs = {input("imu", std::move(of_imu)).about("angular rate and specific force, body axes"),
                 input("gnss", std::move(of_gnss)).about("velocity, twice a second or more")};
  spec.parameters = {
      time("window").above(0).defaults("\"20 s\"").about("time window of the velocities for one attitude"),
      time("every").at_least(0).defaults("\"1 s\"").about("shortest time between attitudes"),
      number("max_heading_sd", "rad")
          .above(0)
          .defaults("\"5 deg\"")
          .about("largest 1-sigma of the heading; less certain attitudes are not emitted"),
      number("max_misfit", "1")
          .above(1)
          .defaults("3")
          .about("largest RMS of the residuals relative to their 1-sigma; attitudes beyond it are not emitted, because "
                 "a sensor is faulty or the antenna is far away"),
      number("course", "rad")
          .above(0)
          .about("1-sigma of the angle between the x axis and the course over ground, for a vehicle that drives "
                 "forward; used if the window gives no attitude; default: the vehicle may move in any direction"),
      number("min_speed", "m/s").above(0).defaults("\"3 m/s\"").about("least speed for a course"),
      number("velocity_sd", "m/s").above(0).about("1-sigma per axis; default: as the channel reports it, else 0.2"),
      number("accelerometer_bias", "m/s^2").above(0).defaults("\"20 mg\"").about("1-sigma per axis"),
      number("gyro_bias", "rad/s").above(0).defaults("\"0.5 deg/s\"").about("1-sigma per axis")};
  spec.example = R"({ "inputs": { "imu": "imu", "gnss": "gnss" }, "window": "20 s" })";
  return spec;
}

InMotionAlignment::InMotionAlignment(const Binding& binding) {
  const Parameters& p = binding.parameters();
  length_ = p.time("window");
  every_ = p.time("every");
  largest_heading_sd_ = p.number("max_heading_sd");
  largest_misfit_ = p.number("max_misfit");
  if (p.has("velocity_sd")) velocity_sd_ = p.number("velocity_sd");
  priors_ = {p.number("accelerometer_bias"), p.number("gyro_bias")};
  if (p.has("course")) course_ = {p.number("course"), p.number("min_speed")};
  imu_ = binding.input("imu");
  gnss_ = binding.input("gnss");
  w_ = binding.fields(imu_, "wx", "wy", "wz");
  f_ = binding.fields(imu_, "fx", "fy", "fz");
  velocity_ = binding.fields(gnss_, "vn", "ve", "vd");
  reported_sd_ = binding.fields(gnss_, "velocity_sd_n", "velocity_sd_e", "velocity_sd_d");
  declare_channels();
  state_ = declaration_.keeps<State>();
}

void InMotionAlignment::declare_channels() {
  ChannelDeclaration attitude;
  attitude_ = attitude.carries(field::level("roll", "rad").about("Euler angles z-y-x, navigation to body"),
                               field::level("pitch", "rad"), field::level("yaw", "rad"));
  attitude.covariance = {{"north", "rad"}, {"east", "rad"}, {"down", "rad"}};
  attitude_channel_ = declaration_.emits(std::move(attitude));
  ChannelDeclaration bias("gyro_bias");
  const auto of_axis = [](const char* axis) { return field::level(axis, "rad/s").about("bias of the gyro"); };
  gyro_bias_ = bias.carries(of_axis("x"), of_axis("y"), of_axis("z"));
  bias.covariance = {{"x", "rad/s"}, {"y", "rad/s"}, {"z", "rad/s"}};
  gyro_bias_channel_ = declaration_.emits(std::move(bias));
}

void InMotionAlignment::initialise(std::uint64_t /*seed*/, const MemoryView& memory) const {
  State& state = memory[state_];
  state.forget();
  state.t_imu = state.t_emitted = no_time;
}

void InMotionAlignment::on(const TransformInput& in, Emitter& emitter) const {
  State& state = in.memory[state_];
  if (in.from == imu_) on_imu(in.sample, state);
  if (in.from == gnss_) on_gnss(in.sample, state, emitter);
}

void InMotionAlignment::on_imu(const SampleView& sample, State& state) const {
  const Vector3d rate = sample[w_], force = sample[f_];
  if (!rate.allFinite() || !force.allFinite()) return;
  const Time before = state.t_imu;
  if (before != no_time && sample.t <= before) return;
  ++state.samples;
  state.t_imu = sample.t;
  Eigen::Map<Vector3d>(state.rate) = rate;
  Eigen::Map<Vector3d>(state.specific_force) = force;
  if (before == no_time || sample.t0 == no_time || sample.t0 - before > longest_hole) return state.forget();
  state.integrals.add(seconds(sample.t - before), rate, force);
}

void InMotionAlignment::on_gnss(const SampleView& sample, State& state, Emitter& emitter) const {
  const Vector3d velocity = sample[velocity_], reported = sample[reported_sd_];
  const Time age = sample.t - state.t_imu;
  if (!velocity.allFinite() || state.t_imu == no_time || age < 0 || age > longest_hole) return;
  // As many as there is room for.
  constexpr Time room = static_cast<Time>(Window::capacity) - 4;
  if (state.window.count() > 0 && (sample.t - state.window.newest()) * room < length_) return;
  ++state.velocities;
  constexpr double unreported = 0.2, least = 0.02;  // m/s
  const double sd = velocity_sd_ ? *velocity_sd_ : reported.allFinite() ? reported.norm() / std::sqrt(3.0) : unreported;
  Epoch epoch{sample.t, {velocity.x(), velocity.y(), velocity.z()}, std::pow(std::max(sd, least), 2), state.integrals};
  const Eigen::Map<const Vector3d> rate(state.rate), specific_force(state.specific_force);
  epoch.since_last.add(seconds(age), rate, specific_force);
  state.window.add(epoch, length_);
  state.integrals = {};
  state.integrals.add(-seconds(age), rate, specific_force);
  if (state.t_emitted != no_time && sample.t - state.t_emitted < every_) return;
  Fit fit;
  if (2 * state.window.span() >= length_) fit = state.window.fit(priors_);
  if (!is_good(fit, state) && course_.sd > 0) fit = state.window.newest(few).fit(priors_, course_);
  if (!is_good(fit, state)) return;
  state.t_emitted = sample.t;
  emit(sample.t, fit, emitter);
}

bool InMotionAlignment::is_good(const Fit& fit, State& state) const {
  if (!fit.is_found) return false;
  const auto note = [](double& least, double value) { least = least == 0 ? value : std::min(least, value); };
  const double sd_heading = std::sqrt(fit.P(2, 2));
  note(state.least_heading_sd, sd_heading);
  note(state.least_misfit, fit.misfit);
  return sd_heading <= largest_heading_sd_ && fit.misfit <= largest_misfit_;
}

void InMotionAlignment::emit(Time t, const Fit& fit, Emitter& emitter) const {
  SampleWriter& attitude = emitter.on(attitude_channel_);
  attitude.t = t;
  attitude[attitude_] = sd::euler_from_quaternion(fit.q_nb);
  attitude.attach_covariance().as<3, 3>() = fit.P;
  emitter.emit(attitude_channel_);
  SampleWriter& bias = emitter.on(gyro_bias_channel_);
  bias.t = t;
  bias[gyro_bias_] = fit.gyro_bias;
  bias.attach_covariance().as<3, 3>() = fit.P_gyro_bias;
  emitter.emit(gyro_bias_channel_);
}

std::string InMotionAlignment::waits_for(const MemoryView& memory) const {
  const State& state = memory[state_];
  if (state.t_emitted != no_time) return "";
  if (state.samples == 0) return "no sample of the IMU came";
  if (state.velocities == 0) return "no velocity came while the IMU ran";
  if (state.least_heading_sd == 0) return "velocities and IMU samples without a hole cover less than half of 'window'";
  char text[160];
  if (!(state.least_misfit <= largest_misfit_))
    std::snprintf(
        text, sizeof text,
        "the residuals were never below %.3g of their 1-sigma (max_misfit %.3g): velocities and IMU contradict "
        "each other",
        state.least_misfit, largest_misfit_);
  else
    std::snprintf(
        text, sizeof text,
        "the heading was never better than %.3g deg (max_heading_sd %.3g deg): the vehicle did not accelerate "
        "or turn enough",
        state.least_heading_sd * 180 / M_PI, largest_heading_sd_ * 180 / M_PI);
  return text;
}

}  // namespace binnacle::in_motion_alignment
