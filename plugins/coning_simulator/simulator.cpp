// SPDX-License-Identifier: Apache-2.0
// The source: a coning motion as increments of an inertial sensor, and truth.
#include "simulator.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "strapdown/rotation.hpp"

namespace binnacle::coning_simulator {

namespace {

constexpr double degree = std::numbers::pi / 180.0;

std::optional<Eigen::Vector3d> read_place(const Parameters& parameters) {
  if (!parameters.has("place")) return std::nullopt;
  const Parameters place = parameters.object("place");
  return Eigen::Vector3d(place.number("lat"), place.number("lon"), place.number("height"));
}

Shaking read_shaking(const Parameters& parameters) {
  return {parameters.vector("acceleration"), parameters.number("phase")};
}

/// Through memory: GCC 12 at -O3 drops conversions to float and back when it vectorizes those of two vectors together.
double rounded_to_single(double value) {
  const volatile float single = static_cast<float>(value);
  return single;
}
Eigen::Vector3d rounded_to_single(const Eigen::Vector3d& v) {
  return {rounded_to_single(v[0]), rounded_to_single(v[1]), rounded_to_single(v[2])};
}

/// To a femtosecond: 0.004 s and not the double next to it, which would be 0.4 ps off after an hour.
long double as_written(double seconds) { return std::round(1e15L * static_cast<long double>(seconds)) / 1e15L; }

}  // namespace

ComponentSpec ConingSimulator::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "coning_simulator";
  spec.summary = "The classical coning motion: exact increments of an inertial sensor, and truth.";
  spec.source = "paper 002, equation (8)";
  spec.parameters = {
      number("half_angle", "rad")
          .at_least(0)
          .at_most(80.0 * degree)
          .defaults("\"2 deg\"")
          .about("half angle of the cone"),
      number("frequency", "Hz").at_least(1e-3).at_most(1e4).required().about("frequency of the coning motion"),
      number("interval", "s").at_least(1e-6).at_most(100).required().about("time between updates of the attitude"),
      integer("samples").at_least(1).at_most(16).defaults("1").about("number of samples per interval"),
      parameter::time("duration")
          .at_least(0)
          .defaults("\"60 s\"")
          .about("duration of the motion, which starts at time zero"),
      number("truth_rate", "Hz")
          .at_least(0)
          .at_most(1e4)
          .defaults("1")
          .about("rate of truth samples, from time zero; 0: none"),
      choice("precision", {"double", "float"})
          .defaults("\"double\"")
          .about("floating-point precision of the increments"),
      vector("acceleration", "m/s^2", 3)
          .defaults("0")
          .about("amplitude of an oscillating acceleration at the coning frequency, navigation axes"),
      number("phase", "rad").defaults("0").about("phase of the acceleration relative to the coning motion"),
      object("place",
             {number("lat", "rad").at_least(-85.0 * degree).at_most(85.0 * degree).required().about("latitude"),
              number("lon", "rad").defaults("0").about("longitude"),
              number("height", "m").at_least(-1e4).at_most(1e5).defaults("0").about("height above the ellipsoid")})
          .about("position on the rotating earth; default: inertial axes without gravity"),
  };
  spec.example = R"json({"frequency": "10 Hz", "interval": "5 ms", "samples": 2})json";
  return spec;
}

ConingSimulator::ConingSimulator(const Binding& binding) : ConingSimulator(binding.parameters()) {}

ConingSimulator::ConingSimulator(const Parameters& parameters)
    : cone_{parameters.number("half_angle"), parameters.number("frequency")},
      motion_(cone_, read_shaking(parameters), read_place(parameters)),
      has_place_(parameters.has("place")),
      is_single_(parameters.text("precision") == "float"),
      interval_(as_written(parameters.number("interval")) / static_cast<long double>(parameters.integer("samples"))),
      duration_(parameters.time("duration")),
      truth_clock_(parameters.number("truth_rate")),
      memory_(declaration_.keeps<Memory>()) {
  declare_channels();
  constexpr double most_cycles = 1e3;
  if (cone_.frequency * static_cast<double>(interval_) > most_cycles)
    throw ComponentError("a sample is longer than 1000 cycles of the cone", "/interval");
}

void ConingSimulator::declare_channels() {
  ChannelDeclaration of_imu("imu"), of_truth("truth");
  imu_ = simulation::carry_imu(of_imu, false);
  of_imu.max_interval = end_of(1) + 1;
  if (has_place_) {
    position_ = of_truth.carries(simulation::position_fields());
    velocity_ = of_truth.carries(simulation::velocity_fields());
  }
  attitude_ = of_truth.carries(simulation::attitude_fields());
  imu_channel_ = declaration_.emits(std::move(of_imu));
  truth_channel_ = declaration_.emits(std::move(of_truth));
}

Time ConingSimulator::end_of(std::int64_t sample) const { return static_cast<Time>(nanoseconds_at(sample) + 0.5L); }

Time ConingSimulator::due(std::int64_t sample) const {
  const bool is_within = simulation::is_instant(nanoseconds_at(sample)) && end_of(sample) <= duration_;
  return is_within ? end_of(sample) : simulation::never;
}

/// The part of a cycle, from the exact product: after an hour a double's would be good to 1e-11 only, and a drift of
/// 1e-6 deg is to be known to four digits.
double ConingSimulator::cycle_at(long double seconds) const {
  const long double cycles = static_cast<long double>(cone_.frequency) * seconds;
  return static_cast<double>(cycles - static_cast<long double>(static_cast<std::int64_t>(cycles)));
}

SourceStatus ConingSimulator::next(const MemoryView& bytes, SourceOutput& out) const {
  Memory& memory = bytes[memory_];
  const Time sample_due = due(memory.next_sample);
  const Time truth_due = truth_clock_.due(memory.next_truth, duration_);
  if (sample_due == simulation::never && truth_due == simulation::never) return SourceStatus::end;
  if (truth_due <= sample_due) {
    ++memory.next_truth;
    emit_truth(truth_due, out.on(truth_channel_));
  } else {
    emit_imu(memory.next_sample++, out.on(imu_channel_));
  }
  return SourceStatus::sample;
}

// Increments belong to the exact intervals; the labels are those to the nearest nanosecond.
void ConingSimulator::emit_imu(std::int64_t sample, SampleWriter& out) const {
  const double middle = cycle_at(interval_ * (static_cast<long double>(sample) - 0.5L));
  simulation::Inertial exact = motion_.increments(middle, static_cast<double>(interval_));
  if (is_single_) {
    exact.omega_ib_b = rounded_to_single(exact.omega_ib_b);
    exact.f_b = rounded_to_single(exact.f_b);
  }
  out.t0 = end_of(sample - 1);
  out.t = end_of(sample);
  out[imu_.w] = exact.omega_ib_b;
  out[imu_.f] = exact.f_b;
}

void ConingSimulator::emit_truth(Time t, SampleWriter& out) const {
  const double cycle = cycle_at(static_cast<long double>(t) / 1e9L);
  const Eigen::Vector3d angles = strapdown::euler_from_quaternion(motion_.attitude(cycle));
  out.t = t;
  if (has_place_) {
    out[position_] = motion_.position(cycle);
    out[velocity_] = motion_.velocity(cycle);
  }
  out[attitude_] = angles;
}

}  // namespace binnacle::coning_simulator
