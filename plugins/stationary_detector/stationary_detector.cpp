// SPDX-License-Identifier: Apache-2.0
// The stationary_detector transform: from inertial samples to channels that speak while the vehicle stands or moves.
#include "stationary_detector.hpp"

#include <cmath>
#include <new>
#include <type_traits>

#include "binnacle/view.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::stationary_detector {

namespace {

using Eigen::Vector3d;

enum Input { imu_input, gyro_bias_input };
enum Channel { standing_channel, moving_channel, state_channel };
enum class State : std::int64_t { unknown, standing, moving };

std::vector<FieldSpec> imu_fields(const char* text) {
  std::vector<FieldSpec> fields;
  for (const char* name : {"wx", "wy", "wz"}) fields.push_back({name, "rad/s", FieldKind::rate, false, false, text});
  for (const char* name : {"fx", "fy", "fz"}) fields.push_back({name, "m/s^2", FieldKind::rate, false, false, text});
  return fields;
}

ChannelDeclaration channel(std::string name, std::vector<FieldSpec> fields, double interval) {
  ChannelDeclaration declaration;
  declaration.name = std::move(name);
  declaration.fields = std::move(fields);
  declaration.max_interval = nanoseconds(interval);
  return declaration;
}

}  // namespace

/// All that it remembers; plain memory in the kernel's arena.
struct StationaryDetector::Memory {
  MotionWindow window;
  Time t;  // end of the last sample; no_time: none yet
  State state;
  double still, not_still;   // s, for how long the window has looked so
  Time since;                // begin of the interval that is being averaged for the next sample of a channel
  double averaged;           // s
  double rate[3], force[3];  // ∫ dt over it
  double gyro_bias[3];       // rad/s, the latest

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
  spec.summary = "Tells from inertial samples whether the vehicle stands or moves.";
  spec.source = "paper 001, section 3 and figure 4, equations (11) and (12)";
  spec.parameters = {
      number("cutoff", "Hz").above(0).at_most(1000).defaults("2").about("of the low-pass filter, -3 dB"),
      time("window").at_least(0.01).at_most(60).defaults("\"1 s\"").about(
          "over which rates are averaged and the force's variance is taken"),
      number("rate_threshold", "rad/s")
          .above(0)
          .defaults("\"0.02 deg/s\"")
          .about("(11): the mean rate's length may differ by less than this from the earth's rate"),
      number("specific_force_variance", "m^2/s^4")
          .above(0)
          .defaults("4e-4")
          .about("(12): the variance of the specific force's length is less than this"),
      time("on").at_least(0).defaults("\"1.5 s\"").about("for how long both must hold before it stands"),
      time("off").at_least(0).defaults("\"0.5 s\"").about("for how long one must fail before it moves"),
      number("standing_rate", "Hz").above(0).at_most(1000).defaults("1").about("samples of the channel standing"),
      number("moving_rate", "Hz").above(0).at_most(1000).defaults("1").about("samples of the channel moving"),
      time("max_gap").above(0).defaults("\"0.5 s\"").about("a longer hole in the samples: it begins anew")};
  ChannelPort bias{"gyro_bias", {}, true, "the latest is taken off the rates, whose bias (11) does not see otherwise"};
  for (const char* name : {"x", "y", "z"})
    bias.fields.push_back({name, "rad/s", FieldKind::level, false, false, "gyroscope bias, body axes"});
  spec.inputs = {{"imu", imu_fields("body axes, whatever they are"), false, "the inertial sensor"}, bias};
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
  const char* mean = "mean over the interval that the statement is about";
  channels_ = {channel("standing", imu_fields(mean), 2 * settings_.standing_period),
               channel("moving", imu_fields(mean), 2 * settings_.moving_period),
               channel("state",
                       {{"standing", "1", FieldKind::level, false, false, "1 while it stands, 0 while it moves"}}, 0)};
}

std::size_t StationaryDetector::memory_bytes() const noexcept { return sizeof(Memory); }

void StationaryDetector::start(std::uint64_t /*seed*/, std::byte* memory) const {
  static_assert(std::is_trivially_copyable_v<Memory> && alignof(Memory) <= 8);
  auto* fresh = new (memory) Memory{};
  fresh->forget();
}

void StationaryDetector::on(int input, const SampleView& sample, std::byte* bytes, Emitter& emitter) const {
  Memory& memory = *std::launder(reinterpret_cast<Memory*>(bytes));
  if (input == imu_input) return on_imu(sample, memory, emitter);
  const Vector3d bias = vector_at<3>(sample.fields);
  if (bias.allFinite()) vector_at<3>(memory.gyro_bias) = bias;
}

void StationaryDetector::on_imu(const SampleView& sample, Memory& memory, Emitter& emitter) const {
  const Vector3d rate = vector_at<3>(sample.fields), force = vector_at<3>(sample.fields + 3);
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
  const double period = memory.state == State::standing ? settings_.standing_period : settings_.moving_period;
  if (memory.state != State::unknown && memory.averaged > 0 && memory.averaged >= period - 0.5 * dt)
    speak(sample.t, memory, emitter);
}

/// (11) and (12).
bool StationaryDetector::looks_still(const Memory& memory) const {
  const WindowFigures now = memory.window.figures();
  const double rate = (now.mean_rate - vector_at<3>(memory.gyro_bias)).norm();
  return std::abs(rate - strapdown::wgs84::omega_ie) < settings_.rate_threshold &&
         now.force_variance < settings_.specific_force_variance;
}

/// Figure 4: the counter, which tells a shake from driving off.
void StationaryDetector::decide(Time t, Memory& memory, Emitter& emitter) const {
  constexpr double roundoff = 1e-9;  // s, of sums of parts
  const bool still = looks_still(memory);
  memory.still = still ? memory.still + memory.window.last_part() : 0.0;
  memory.not_still = still ? 0.0 : memory.not_still + memory.window.last_part();
  const State before = memory.state;
  if (still && memory.still >= settings_.on - roundoff) memory.state = State::standing;
  if (!still && memory.not_still >= settings_.off - roundoff) memory.state = State::moving;
  if (memory.state != before) memory.begin_interval(t);
  if (memory.state == State::unknown) return;
  SampleSlot& slot = emitter.slot(state_channel);
  slot.t = t;
  slot.fields[0] = memory.state == State::standing ? 1.0 : 0.0;
  emitter.emit(state_channel);
}

void StationaryDetector::speak(Time t, Memory& memory, Emitter& emitter) const {
  const Channel channel = memory.state == State::standing ? standing_channel : moving_channel;
  SampleSlot& slot = emitter.slot(channel);
  slot.t = t;
  slot.t0 = memory.since;
  vector_at<3>(slot.fields) = vector_at<3>(memory.rate) / memory.averaged;
  vector_at<3>(slot.fields + 3) = vector_at<3>(memory.force) / memory.averaged;
  emitter.emit(channel);
  memory.begin_interval(t);
}

}  // namespace binnacle::stationary_detector
