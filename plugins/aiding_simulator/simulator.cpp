// SPDX-License-Identifier: Apache-2.0
// The aiding_simulator transform: from where a vehicle is to what its sensors read.
#include "simulator.hpp"

#include <cmath>
#include <utility>

#include "random/normal.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::aiding_simulator {

namespace {

FieldSpec rate(const char* name) {
  return field::level(name, "rad/s").optional().about("angular rate with respect to inertial space, for lever arms");
}

}  // namespace

struct AidingSimulator::SensorMemory {
  Time last = no_time;  // reading
  random::Philox noise{};
};

struct AidingSimulator::ErrorMemory {
  double constant, wandering;
  random::Philox stream;
};

ComponentSpec AidingSimulator::spec() {
  ComponentSpec spec;
  spec.type = "aiding_simulator";
  spec.summary =
      "Measurements of sensors on a simulated vehicle besides GNSS and IMU: magnetometer, barometer, DVL, headings.";
  spec.source =
      "Groves, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., sections 6.1.1, "
      "6.2.1 and 6.5";
  for (SensorKind& kind : sensor_kinds()) spec.parameters.push_back(std::move(kind.spec));
  spec.parameters.push_back(parameter::boolean("perfect").defaults("false").about("true: no errors"));
  spec.inputs = {
      input("truth",
            {field::level("lat", "rad").about("geodetic latitude"), field::level("lon", "rad").about("longitude"),
             field::level("height", "m").about("height above the ellipsoid"),
             field::level("vn", "m/s").about("velocity over ground, north"),
             field::level("ve", "m/s").about("velocity over ground, east"),
             field::level("vd", "m/s").about("velocity over ground, down"),
             field::level("roll", "rad").about("of the body"), field::level("pitch", "rad").about("of the body"),
             field::level("yaw", "rad").about("of the body"), rate("omega_x"), rate("omega_y"), rate("omega_z")})
          .about("true motion of the vehicle; measurements are at times of its samples")};
  spec.example = R"json({"input": "drive.truth",
    "magnetometer": {"every": "0.1 s", "declination": "3.5 deg", "inclination": "64 deg", "strength": "48 uT",
                     "noise": "0.25 uT", "hard_iron": "2 uT"},
    "height": {"noise": "0.3 m", "bias": "2 m", "lever_arm": [0, 0, "-1 m"]}})json";
  return spec;
}

AidingSimulator::AidingSimulator(const Binding& binding) : is_perfect_(binding.parameters().boolean("perfect")) {
  const Input input = binding.input("truth");
  position_ = binding.fields(input, "lat", "lon", "height");
  velocity_ = binding.fields(input, "vn", "ve", "vd");
  attitude_ = binding.fields(input, "roll", "pitch", "yaw");
  rates_ = binding.fields(input, "omega_x", "omega_y", "omega_z");
  ChannelDeclaration truth("truth");
  std::size_t errors = 0;
  for (const SensorKind& kind : sensor_kinds()) {
    if (!binding.parameters().has(kind.name)) continue;
    const Parameters own = binding.parameters().object(kind.name);
    std::unique_ptr<Sensor> sensor = kind.make(own);
    if (sensor->needs_rates() && !rates_.is_bound())
      throw ComponentError(
          "a velocity at a lever arm needs 'omega_x', 'omega_y' and 'omega_z', which the channel does not carry",
          std::string("/") + kind.name + "/lever_arm");
    ChannelDeclaration channel(kind.name);
    sensor->declare(channel);
    Part part{kind.name, nullptr, own.time("every"), sensor->errors(), errors, declaration_.emits(std::move(channel))};
    for (SlowError& error : part.errors) {
      if (is_perfect_) error.constant = error.wandering = 0;
      error_fields_.push_back(truth.carries(field::level(part.name + "_" + error.name, error.unit).about(error.text)));
    }
    errors += part.errors.size();
    part.sensor = std::move(sensor);
    parts_.push_back(std::move(part));
  }
  if (parts_.empty()) throw ComponentError("no sensor is given: 'magnetometer', 'height', …", "");
  if (errors > 0) truth_ = declaration_.emits(std::move(truth));
  last_ = declaration_.keeps<Time>();
  of_sensor_ = declaration_.keeps_array<SensorMemory>(parts_.size());
  of_error_ = declaration_.keeps_array<ErrorMemory>(errors);
  values_ = declaration_.keeps_array<double>(errors);
}

void AidingSimulator::initialise(std::uint64_t seed, const MemoryView& bytes) const {
  bytes[last_] = no_time;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    bytes[of_sensor_][i] = {no_time, random::stream(seed, part.name + ".noise")};
    for (std::size_t k = 0; k < part.errors.size(); ++k) {
      ErrorMemory& memory = bytes[of_error_][part.first_error + k];
      memory.stream = random::stream(seed, part.name + "." + part.errors[k].name);
      memory.constant = part.errors[k].constant * random::normal(memory.stream);
      memory.wandering = part.errors[k].wandering * random::normal(memory.stream);
      bytes[values_][part.first_error + k] = memory.constant + memory.wandering;
    }
  }
}

void AidingSimulator::advance(const MemoryView& bytes, double dt) const {
  for (const Part& part : parts_)
    for (std::size_t k = 0; k < part.errors.size(); ++k) {
      const SlowError& error = part.errors[k];
      if (error.wandering == 0) continue;
      ErrorMemory& memory = bytes[of_error_][part.first_error + k];
      const double kick = error.wandering * std::sqrt(-std::expm1(-2 * dt / error.tau));
      memory.wandering = std::exp(-dt / error.tau) * memory.wandering + kick * random::normal(memory.stream);
      bytes[values_][part.first_error + k] = memory.constant + memory.wandering;
    }
}

void AidingSimulator::emit_errors(Time t, const MemoryView& bytes, Emitter& emitter) const {
  if (error_fields_.empty()) return;
  SampleWriter& out = emitter.on(truth_);
  out.t = t;
  for (std::size_t i = 0; i < error_fields_.size(); ++i) out[error_fields_[i]] = bytes[values_][i];
  emitter.emit(truth_);
}

void AidingSimulator::on(const TransformInput& in, Emitter& emitter) const {
  const SampleView& sample = in.sample;
  const Eigen::Vector3d angles = sample[attitude_];
  const Truth truth{sample[position_], sample[velocity_],
                    strapdown::dcm_from_quaternion(strapdown::quaternion_from_euler(angles)), sample[rates_]};
  if (!truth.lla.allFinite() || !truth.v_n.allFinite() || !angles.allFinite()) return;
  Time& last = in.memory[last_];
  if (last != no_time && sample.t > last) advance(in.memory, seconds(sample.t - last));
  last = sample.t;
  emit_errors(sample.t, in.memory, emitter);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    SensorMemory& memory = in.memory[of_sensor_][i];
    if (memory.last != no_time && sample.t - memory.last < part.every) continue;
    memory.last = sample.t;
    SampleWriter& out = emitter.on(part.channel);
    out.t = sample.t;
    const std::span<const double> errors = in.memory[values_];
    Noise noise(memory.noise, is_perfect_);
    part.sensor->measure(truth, errors.subspan(part.first_error, part.errors.size()), noise, out);
    emitter.emit(part.channel);
  }
}

}  // namespace binnacle::aiding_simulator
