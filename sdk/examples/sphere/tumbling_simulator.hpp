// SPDX-License-Identifier: Apache-2.0
// A body that tumbles, its gyros, a sensor that sees one direction, and the truth.
#pragma once

#include <binnacle/plugin.hpp>

#include <array>
#include <cmath>
#include <utility>

#include "common/random.hpp"
#include "s2.hpp"

/// The rates swing about all three axes, so that the direction comes everywhere. It knows nothing of turning's closed
/// form: ẋ = −ω × x is integrated in small steps (the midpoint rule).
class TumblingWorld {
 public:
  /// Plain memory: the whole state of a simulation.
  struct State {
    Random random{};
    double x[3] = {}, bias[3] = {};  // 1, rad/s
    std::int64_t steps = 0;
    double rates[3] = {}, seen[3] = {};  // as measured: mean over the last step [rad/s], at its end [1]
  };
  static constexpr double interval = 0.1;  // s

  static std::vector<binnacle::ParameterSpec> parameters() {
    using namespace binnacle::parameter;
    std::vector<binnacle::ParameterSpec> specs;
    specs.push_back(vector("direction", "1", 3).required().about("mean of it at the start: x, y, z"));
    specs.push_back(number("direction_sigma", "rad").at_least(0).at_most(1).defaults("0").about("at the start"));
    specs.push_back(number("bias_sigma", "rad/s").at_least(0).defaults("0").about("of each gyro's bias, run by run"));
    specs.push_back(number("rate", "rad/s").at_least(0).at_most(10).defaults("\"20 deg/s\"").about("how fast"));
    specs.push_back(number("gyro_noise", "rad/s/sqrt(Hz)").at_least(0).defaults("0").about("of each gyro"));
    specs.push_back(number("sigma", "rad").at_least(0).at_most(1).defaults("0").about("of the direction that is seen"));
    return specs;
  }

  explicit TumblingWorld(const binnacle::Parameters& p)
      : direction_(p.vector("direction")),
        direction_sigma_(p.number("direction_sigma")),
        bias_sigma_(p.number("bias_sigma")),
        rate_(p.number("rate")),
        gyro_noise_(p.number("gyro_noise")),
        sigma_(p.number("sigma")) {
    if (!(std::abs(direction_.norm() - 1) < 0.01))
      throw binnacle::ComponentError("x, y, z are a vector of length 1", "/direction");
    direction_.normalize();
  }

  State start(std::uint64_t seed) const {
    State world;
    world.random = binnacle::random::stream(seed, "body");
    binnacle::vector_at<3>(world.x) = spread(direction_, direction_sigma_, world.random);
    for (double& bias : world.bias) bias = bias_sigma_ * normal(world.random);
    return world;
  }

  /// The next tenth of a second.
  void step(State& world) const {
    constexpr int parts = 20;
    constexpr double dt = interval / parts;
    s2::Vector3 x = binnacle::vector_at<3>(world.x), turned = s2::Vector3::Zero();
    for (int part = 0; part < parts; ++part) {
      const s2::Vector3 rates = rates_at(interval * static_cast<double>(world.steps) + dt * (part + 0.5));
      const s2::Vector3 middle = x - dt / 2 * rates.cross(x);
      x = (x - dt * rates.cross(middle)).normalized();
      turned += dt * rates;
    }
    ++world.steps;
    binnacle::vector_at<3>(world.x) = x;
    for (int axis = 0; axis < 3; ++axis)
      world.rates[axis] =
          turned[axis] / interval + world.bias[axis] + gyro_noise_ / std::sqrt(interval) * normal(world.random);
    binnacle::vector_at<3>(world.seen) = spread(x, sigma_, world.random);
  }

 private:
  s2::Vector3 rates_at(double t) const {
    return rate_ * s2::Vector3(std::sin(0.3 * t), std::cos(0.23 * t), 0.5 + 0.5 * std::sin(0.11 * t));
  }
  /// Turned by a normal error about two axes across x, made without the axes of the block.
  static s2::Vector3 spread(const s2::Vector3& x, double sigma, Random& random) {
    s2::Vector3 across;
    for (int axis = 0; axis < 3; ++axis) across[axis] = sigma * normal(random);
    across -= x.dot(across) * x;
    const double angle = across.norm();
    return angle > 0 ? s2::Vector3(std::cos(angle) * x + std::sin(angle) / angle * across) : x;
  }

  s2::Vector3 direction_;
  double direction_sigma_, bias_sigma_, rate_;  // rad, rad/s, rad/s
  double gyro_noise_, sigma_;                   // rad/s/√Hz, rad
};

/// The world's sensors every tenth of a second, the direction every second: NAME.gyro, NAME.seen, NAME.truth.
class TumblingSimulator final : public binnacle::Source {
 public:
  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    ComponentSpec spec;
    spec.type = "tumbling_simulator";
    spec.summary = "A body that tumbles, with gyros and a sensor for one direction.";
    spec.source = "the differential equation of a fixed direction in turning axes, integrated in small steps";
    spec.parameters = TumblingWorld::parameters();
    spec.parameters.push_back(parameter::time("duration").at_least(0).defaults("\"60 s\"").about("of the whole"));
    spec.example = R"json({"direction": [0, 0.6, 0.8], "direction_sigma": "5 deg", "bias_sigma": "0.2 deg/s",
      "gyro_noise": "0.1 deg/s/sqrt(Hz)", "sigma": "0.5 deg"})json";
    return spec;
  }

  explicit TumblingSimulator(const binnacle::Binding& b)
      : world_(b.parameters()), steps_(b.parameters().time("duration") / step_time) {
    using namespace binnacle;
    ChannelDeclaration gyro("gyro"), seen("seen"), truth("truth");
    const auto rate = [](const char* name) { return field::rate(name, "rad/s").about("rate"); };
    const auto axis = [](const char* name) { return field::level(name, "1").about("body axis"); };
    const auto bias = [](const char* name) { return field::level(name, "rad/s").about("bias of a gyro"); };
    rates_ = gyro.carries(rate("wx"), rate("wy"), rate("wz"));
    gyro.max_interval = step_time;
    seen_ = seen.carries(axis("x"), axis("y"), axis("z"));
    true_ = truth.carries(axis("x"), axis("y"), axis("z"));
    bias_ = truth.carries(bias("bx"), bias("by"), bias("bz"));
    channels_ = {declaration_.emits(std::move(gyro)), declaration_.emits(std::move(seen)),
                 declaration_.emits(std::move(truth))};
    memory_ = declaration_.keeps<Memory>();
  }

  binnacle::SourceStatus next(const binnacle::MemoryView& bytes, binnacle::SourceOutput& output) const override {
    Memory& m = bytes[memory_];
    if (m.channel < 0 || m.channel > 2 || m.world.steps < 0 || m.world.steps >= steps_ + (m.channel > 0))
      return binnacle::SourceStatus::end;
    if (m.channel == 0) world_.step(m.world);
    binnacle::SampleWriter& out = output.on(channels_[static_cast<std::size_t>(m.channel)]);
    out.t = step_time * m.world.steps;
    using binnacle::vector_at;
    if (m.channel == 0) out.t0 = out.t - step_time, out[rates_] = vector_at<3>(m.world.rates);
    if (m.channel == 1) out[seen_] = vector_at<3>(m.world.seen);
    if (m.channel == 2) out[true_] = vector_at<3>(m.world.x), out[bias_] = vector_at<3>(m.world.bias);
    m.channel = m.channel == 0 && m.world.steps % 10 != 0 ? 2 : (m.channel + 1) % 3;
    return binnacle::SourceStatus::sample;
  }

 private:
  static constexpr binnacle::Time step_time = 100'000'000;
  struct Memory {
    TumblingWorld::State world;
    int channel = 0;  // whose turn it is
  };
  void initialise(std::uint64_t seed, const binnacle::MemoryView& bytes) const override {
    bytes[memory_].world = world_.start(seed);
  }

  TumblingWorld world_;
  std::int64_t steps_;
  std::array<binnacle::OutputChannel, 3> channels_;
  binnacle::OutputFields<3> rates_, seen_, true_, bias_;
  binnacle::Memory<Memory> memory_;
};
