// SPDX-License-Identifier: Apache-2.0
// The stationary_detector transform: from inertial samples to channels that emit while the vehicle stands or moves.
#include "stationary_detector.hpp"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "binnacle/view.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::stationary_detector {

namespace {

using Eigen::Vector3d;

using Triad = std::array<FieldSpec, 3>;

Triad triad(const char* const (&names)[3], const char* unit, FieldKind kind, const char* text) {
  Triad fields;
  for (std::size_t i = 0; i < 3; ++i) fields[i] = {names[i], unit, kind, false, false, text};
  return fields;
}
Triad rates(const char* text) { return triad({"wx", "wy", "wz"}, "rad/s", FieldKind::rate, text); }
Triad forces(const char* text) { return triad({"fx", "fy", "fz"}, "m/s^2", FieldKind::rate, text); }

}  // namespace

/// All that it remembers; plain memory in the kernel's arena.
struct StationaryDetector::Memory {
  enum class State : std::int64_t { unknown, standing, moving };
  MotionWindow window{};
  Time t = no_time;  // end of the last sample; no_time: none yet
  State state = State::unknown;
  double still = 0, not_still = 0;     // s, for how long the window has looked so
  Time since = no_time;                // begin of the interval that is averaged for the next sample of a channel
  double averaged = 0;                 // s
  double rate[3] = {}, force[3] = {};  // ∫ dt over it
  double gyro_bias[3] = {};            // rad/s, the latest

  void forget() {
    window.clear();
    t = no_time;
    state = State::unknown;
    still = not_still = 0;
    begin_interval(no_time);
  }
  void begin_interval(Time from) {
    since = from;
    averaged = 0;
    for (int i = 0; i < 3; ++i) rate[i] = force[i] = 0;
  }
};

ComponentSpec StationaryDetector::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "stationary_detector";
  spec.summary = "Detects from inertial samples whether the vehicle stands or moves.";
  spec.source = "paper 001, section 3 and figure 4, equations (11) and (12)";
  spec.parameters = {
      number("cutoff", "Hz")
          .above(0)
          .at_most(1000)
          .defaults("2")
          .about("cutoff frequency of the low-pass filter, -3 dB"),
      time("window").at_least(0.01).at_most(60).defaults("\"1 s\"").about(
          "time window of the mean rates and of the specific force's variance"),
      number("rate_threshold", "rad/s")
          .above(0)
          .defaults("\"0.02 deg/s\"")
          .about("test (11): largest difference between the length of the mean rate and the earth rate"),
      number("specific_force_variance", "m^2/s^4")
          .above(0)
          .defaults("4e-4")
          .about("test (12): largest variance of the length of the specific force"),
      time("on")
          .at_least(0)
          .defaults("\"1.5 s\"")
          .about("time for which both tests must hold before the state becomes standing"),
      time("off")
          .at_least(0)
          .defaults("\"0.5 s\"")
          .about("time for which one test must fail before the state becomes moving"),
      number("standing_rate", "Hz").above(0).at_most(1000).defaults("1").about("sample rate of the channel standing"),
      number("moving_rate", "Hz").above(0).at_most(1000).defaults("1").about("sample rate of the channel moving"),
      time("max_gap")
          .above(0)
          .defaults("\"0.5 s\"")
          .about("longest hole in the samples; a longer hole restarts the detector")};
  std::vector<FieldSpec> of_imu;
  for (const Triad& part : {rates("body axes of any orientation"), forces("body axes of any orientation")})
    of_imu.insert(of_imu.end(), part.begin(), part.end());
  const Triad bias = triad({"x", "y", "z"}, "rad/s", FieldKind::level, "gyroscope bias, body axes");
  spec.inputs = {input("imu", of_imu).about("the inertial sensor"),
                 input("gyro_bias", {bias.begin(), bias.end()})
                     .optional()
                     .about("latest bias, subtracted from the rates; without it, test (11) includes the bias")};
  spec.example = R"json({"input": "imu", "standing_rate": 1, "moving_rate": 1})json";
  return spec;
}

StationaryDetector::StationaryDetector(const Binding& binding) {
  const Parameters& parameters = binding.parameters();
  settings_.window = {parameters.number("cutoff"), seconds(parameters.time("window"))};
  settings_.rate_threshold = parameters.number("rate_threshold");
  settings_.specific_force_variance = parameters.number("specific_force_variance");
  settings_.on = seconds(parameters.time("on"));
  settings_.off = seconds(parameters.time("off"));
  settings_.max_gap = parameters.time("max_gap");
  settings_.standing_period = 1.0 / parameters.number("standing_rate");
  settings_.moving_period = 1.0 / parameters.number("moving_rate");
  imu_ = binding.input("imu");
  gyro_bias_ = binding.input("gyro_bias");
  w_ = binding.fields(imu_, "wx", "wy", "wz");
  f_ = binding.fields(imu_, "fx", "fy", "fz");
  bias_ = binding.fields(gyro_bias_, "x", "y", "z");
  declare_channels();
  memory_ = declaration_.keeps<Memory>();
}

void StationaryDetector::declare_channels() {
  const auto mean = [&](const char* name, double period) {
    const char* const text = "mean over the interval that the statement is about";
    ChannelDeclaration channel(name);
    channel.max_interval = nanoseconds(2 * period);
    Mean handles;
    handles.w = channel.carries(rates(text));
    handles.f = channel.carries(forces(text));
    handles.channel = declaration_.emits(std::move(channel));
    return handles;
  };
  standing_ = mean("standing", settings_.standing_period);
  moving_ = mean("moving", settings_.moving_period);
  ChannelDeclaration state("state");
  is_standing_ = state.carries(field::level("standing", "1").about("1 while it stands, 0 while it moves"));
  state_channel_ = declaration_.emits(std::move(state));
}

void StationaryDetector::on(const TransformInput& in, Emitter& emitter) const {
  Memory& memory = in.memory[memory_];
  if (in.from == imu_) return on_imu(in.sample, memory, emitter);
  const Vector3d bias = in.sample[bias_];
  if (bias.allFinite()) vector_at<3>(memory.gyro_bias) = bias;
}

void StationaryDetector::on_imu(const SampleView& sample, Memory& memory, Emitter& emitter) const {
  const Vector3d rate = sample[w_], force = sample[f_];
  if (!rate.allFinite() || !force.allFinite()) return;  // what it leaves is a hole
  if (sample.t == memory.t) return;
  const auto elapsed = static_cast<std::uint64_t>(sample.t) - static_cast<std::uint64_t>(memory.t);
  if (memory.t == no_time || sample.t < memory.t || elapsed > static_cast<std::uint64_t>(settings_.max_gap)) {
    memory.forget();
    memory.t = memory.since = sample.t;
    return;  // starts the clock
  }
  const double dt = seconds(static_cast<Time>(elapsed));
  memory.t = sample.t;
  vector_at<3>(memory.rate) += rate * dt;
  vector_at<3>(memory.force) += force * dt;
  memory.averaged += dt;
  if (memory.window.add(settings_.window, dt, rate, force) && memory.window.is_full())
    decide(sample.t, memory, emitter);
  const double period = memory.state == Memory::State::standing ? settings_.standing_period : settings_.moving_period;
  if (memory.state != Memory::State::unknown && memory.averaged > 0 && memory.averaged >= period - 0.5 * dt)
    emit_state(sample.t, memory, emitter);
}

/// (11) and (12).
bool StationaryDetector::looks_still(const Memory& memory) const {
  const WindowFigures now = memory.window.figures();
  const double rate = (now.mean_rate - vector_at<3>(memory.gyro_bias)).norm();
  return std::abs(rate - strapdown::wgs84::omega_ie) < settings_.rate_threshold &&
         now.force_variance < settings_.specific_force_variance;
}

/// Figure 4: the counter, which distinguishes a shake from driving off.
void StationaryDetector::decide(Time t, Memory& memory, Emitter& emitter) const {
  constexpr double roundoff = 1e-9;  // s, of sums of parts
  const bool still = looks_still(memory);
  memory.still = still ? memory.still + memory.window.last_part() : 0.0;
  memory.not_still = still ? 0.0 : memory.not_still + memory.window.last_part();
  const Memory::State before = memory.state;
  if (still && memory.still >= settings_.on - roundoff) memory.state = Memory::State::standing;
  if (!still && memory.not_still >= settings_.off - roundoff) memory.state = Memory::State::moving;
  if (memory.state != before) memory.begin_interval(t);
  if (memory.state == Memory::State::unknown) return;
  SampleWriter& out = emitter.on(state_channel_);
  out.t = t;
  out[is_standing_] = memory.state == Memory::State::standing ? 1.0 : 0.0;
  emitter.emit(state_channel_);
}

void StationaryDetector::emit_state(Time t, Memory& memory, Emitter& emitter) const {
  const Mean& mean = memory.state == Memory::State::standing ? standing_ : moving_;
  SampleWriter& out = emitter.on(mean.channel);
  out.t = t;
  out.t0 = memory.since;
  out[mean.w] = vector_at<3>(memory.rate) / memory.averaged;
  out[mean.f] = vector_at<3>(memory.force) / memory.averaged;
  emitter.emit(mean.channel);
  memory.begin_interval(t);
}

}  // namespace binnacle::stationary_detector
