// SPDX-License-Identifier: Apache-2.0
// The source: a target seen from a vessel that changes its course.
#include "simulator.hpp"

#include <cmath>
#include <numbers>

#include "random/normal.hpp"

namespace binnacle::target_simulator {

using simulation::never;

/// All that changes while the source runs: plain memory in the kernel's arena.
struct TargetSimulator::Memory {
  std::int64_t next;           // tick
  std::int64_t is_truth_next;  // of the same tick
  double p[2], v[2];           // of the target at the last tick: m, m/s
  random::Philox wander_stream, noise_stream;
};

ComponentSpec TargetSimulator::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "target_simulator";
  spec.summary = "A target in a plane: azimuths measured by an observer on known legs, and truth.";
  spec.source = "Aidala, Kalman filter behavior in bearings-only tracking applications, IEEE TAES 15(1), 1979";
  spec.parameters = {
      time("duration").above(0).defaults("\"600 s\"").about("duration from time zero"),
      number("rate", "Hz")
          .above(0)
          .at_most(1e3)
          .defaults("0.2")
          .about("sample rate of bearings and of truth, from time zero"),
      number("sigma", "rad")
          .at_least(0)
          .defaults("\"0.5 deg\"")
          .about("standard deviation of the azimuth's white noise"),
      object("target", {vector("position", "m", 2).required().about("expected initial position: north, east"),
                        vector("velocity", "m/s", 2).defaults("0").about("expected initial velocity: north, east"),
                        vector("position_sigma", "m", 2)
                            .at_least(0)
                            .defaults("0")
                            .about("standard deviation of the initial position, drawn in each run"),
                        vector("velocity_sigma", "m/s", 2)
                            .at_least(0)
                            .defaults("0")
                            .about("standard deviation of the initial velocity, drawn in each run"),
                        number("q", "m/s/sqrt(s)")
                            .at_least(0)
                            .defaults("0")
                            .about("root of the power spectral density of the target's acceleration")})
          .required()
          .about(
              "initial estimate of the target; the truth is drawn about it: truth = initial estimate + N(0, sigma^2)"),
      vector("observer", "m", 2).defaults("0").about("initial position of the observer: north, east"),
      list("legs", object("leg", {time("duration").above(0).required().about("duration of the leg"),
                                  vector("velocity", "m/s", 2).required().about("velocity: north, east")}))
          .required()
          .about("legs of the observer, which continues on the last one")};
  spec.example = R"json({"target": {"position": [5000, 0], "position_sigma": [1500, 100]},
    "legs": [{"duration": "2 min", "velocity": [0, 10]}, {"duration": "2 min", "velocity": [10, 0]}]})json";
  return spec;
}

TargetSimulator::TargetSimulator(const Binding& binding)
    : duration_(binding.parameters().time("duration")),
      clock_(binding.parameters().number("rate")),
      sigma_(binding.parameters().number("sigma")),
      memory_(declaration_.keeps<Memory>()) {
  const Parameters target = binding.parameters().object("target");
  p0_ = target.vector("position");
  v0_ = target.vector("velocity");
  p_sigma_ = target.vector("position_sigma");
  v_sigma_ = target.vector("velocity_sigma");
  q_ = target.number("q");
  Leg leg{0, binding.parameters().vector("observer"), Vector2d::Zero()};
  for (const auto& each : binding.parameters().list("legs")) {
    const Parameters next(each);
    leg.v = next.vector("velocity");
    legs_.push_back(leg);
    const double length = seconds(next.time("duration"));
    leg.from += length;
    leg.p += length * leg.v;
  }
  if (legs_.empty()) throw ComponentError("the observer has no leg", "/legs");
  declare_channels();
}

void TargetSimulator::declare_channels() {
  ChannelDeclaration bearing("bearing"), truth("truth");
  azimuth_ = bearing.carries(field::level("azimuth", "rad").about("of the target, clockwise from north"));
  observer_ = bearing.carries(field::level("observer_north", "m"), field::level("observer_east", "m"));
  position_ = truth.carries(field::level("north", "m"), field::level("east", "m"));
  velocity_ = truth.carries(field::level("vn", "m/s"), field::level("ve", "m/s"));
  bearing_channel_ = declaration_.emits(std::move(bearing));
  truth_channel_ = declaration_.emits(std::move(truth));
}

/// A stream for each, so no parameter changes the draws of another.
void TargetSimulator::initialise(std::uint64_t seed, const MemoryView& bytes) const {
  Memory memory{.next = 0,
                .is_truth_next = 0,
                .p = {},
                .v = {},
                .wander_stream = random::stream(seed, "target.acceleration"),
                .noise_stream = random::stream(seed, "bearing")};
  auto position = random::stream(seed, "target.position"), velocity = random::stream(seed, "target.velocity");
  for (int i = 0; i < 2; ++i) {
    memory.p[i] = p0_[i] + p_sigma_[i] * random::normal(position);
    memory.v[i] = v0_[i] + v_sigma_[i] * random::normal(velocity);
  }
  bytes[memory_] = memory;
}

/// To the next tick. The increments over dt have the covariance q² [dt³/3, dt²/2; dt²/2, dt].
void TargetSimulator::advance(Memory& memory) const {
  if (memory.next == 0) return;  // the target starts there
  const double dt = clock_.interval_before(memory.next), root = q_ * std::sqrt(dt);
  for (int i = 0; i < 2; ++i) {
    const double a = random::normal(memory.wander_stream), b = random::normal(memory.wander_stream);
    memory.p[i] += dt * memory.v[i] + root * dt * (0.5 * a + b / std::sqrt(12.0));
    memory.v[i] += root * a;
  }
}

Vector2d TargetSimulator::observer_at(double t) const {
  const Leg* now = &legs_.front();
  for (const Leg& leg : legs_)
    if (leg.from <= t) now = &leg;
  return now->p + (t - now->from) * now->v;
}

SourceStatus TargetSimulator::next(const MemoryView& bytes, SourceOutput& out) const {
  Memory& memory = bytes[memory_];
  const Time t = clock_.due(memory.next, duration_);
  if (t == never) return SourceStatus::end;
  if (memory.is_truth_next == 0) {
    memory.is_truth_next = 1;
    advance(memory);
    SampleWriter& sample = out.on(bearing_channel_);
    const Vector2d observer = observer_at(seconds(t)), d = Vector2d(memory.p[0], memory.p[1]) - observer;
    const double azimuth = std::atan2(d[1], d[0]) + sigma_ * random::normal(memory.noise_stream);
    sample.t = t;
    sample[azimuth_] = std::remainder(azimuth, 2 * std::numbers::pi);
    sample[observer_] = observer;
    return SourceStatus::sample;
  }
  memory.is_truth_next = 0;
  ++memory.next;
  SampleWriter& sample = out.on(truth_channel_);
  sample.t = t;
  sample[position_] = Vector2d(memory.p[0], memory.p[1]);
  sample[velocity_] = Vector2d(memory.v[0], memory.v[1]);
  return SourceStatus::sample;
}

}  // namespace binnacle::target_simulator
