// SPDX-License-Identifier: Apache-2.0
// A cell that is driven around, its sensors, and the truth.
#pragma once

#include <binnacle/plugin.hpp>

#include <array>
#include <cmath>
#include <utility>

#include "common/random.hpp"
#include "ocv_curve.hpp"

/// A cell under a load of one minute that repeats: 20 s at 3 A, 10 s at 6 A, 10 s charged with 3 A, 20 s at rest.
///
/// It knows nothing of thevenin's closed form: the differential equations are integrated in small steps (Heun).
class CellWorld {
 public:
  /// Plain memory: the whole state of a simulation.
  struct State {
    Random random{};
    double soc = 0, rc = 0;  // 1, V
    std::int64_t second = 0;
    double current = 0;  // as measured: mean of the second that ended [A]
    double voltage = 0;  // as measured, at its end [V]
  };

  static std::vector<binnacle::ParameterSpec> parameters() {
    using namespace binnacle::parameter;
    auto specs = ocv_curve::parameters();
    specs.push_back(number("soc", "1").at_least(0).at_most(1).required().about("mean of the charge at the start"));
    specs.push_back(number("soc_sigma", "1").at_least(0).defaults("0").about("its standard deviation, run by run"));
    specs.push_back(number("capacity", "A*s").above(0).required().about("charge between empty and full"));
    specs.push_back(number("r0", "V/A").at_least(0).required().about("series resistance"));
    specs.push_back(number("r1", "V/A").above(0).required().about("resistor of the RC pair"));
    specs.push_back(number("c1", "A*s/V").above(0).required().about("capacitor of the RC pair"));
    specs.push_back(number("coulombic_efficiency", "1")
                        .above(0)
                        .at_most(1)
                        .defaults("1")
                        .about("share of the charge that stays while charging"));
    specs.push_back(number("current_noise", "A/sqrt(Hz)").at_least(0).defaults("0").about("of the current sensor"));
    specs.push_back(number("voltage_sigma", "V").at_least(0).defaults("0").about("of the voltage sensor"));
    return specs;
  }

  explicit CellWorld(const binnacle::Parameters& p)
      : ocv_(ocv_curve::of(p)),
        soc_(p.number("soc")),
        soc_sigma_(p.number("soc_sigma")),
        capacity_(p.number("capacity")),
        r0_(p.number("r0")),
        r1_(p.number("r1")),
        c1_(p.number("c1")),
        efficiency_(p.number("coulombic_efficiency")),
        current_noise_(p.number("current_noise")),
        voltage_sigma_(p.number("voltage_sigma")) {}

  State start(std::uint64_t seed) const {
    State world;
    world.random = binnacle::random::stream(seed, "cell");
    world.soc = soc_ + soc_sigma_ * normal(world.random);
    return world;
  }

  /// One second.
  void step(State& world) const {
    const double I = load(world.second++);
    constexpr int parts = 100;
    constexpr double dt = 1.0 / parts;
    for (int i = 0; i < parts; ++i) {
      const double predicted = world.rc + dt * rc_rate(world.rc, I);
      world.rc += dt / 2 * (rc_rate(world.rc, I) + rc_rate(predicted, I));
      world.soc -= dt * (I < 0 ? efficiency_ : 1) * I / capacity_;
    }
    world.current = I + current_noise_ * normal(world.random);  // mean over 1 s: q / √(1 s)
    world.voltage = ocv_.at(world.soc).volts - world.rc - r0_ * I + voltage_sigma_ * normal(world.random);
  }

 private:
  static double load(std::int64_t second) {
    const auto s = second % 60;
    return s < 20 ? 3 : s < 30 ? 6 : s < 40 ? -3 : 0;
  }
  double rc_rate(double rc, double I) const { return (I - rc / r1_) / c1_; }

  OcvCurve ocv_;
  double soc_, soc_sigma_, capacity_, r0_, r1_, c1_, efficiency_;  // 1, 1, A s, V/A, V/A, A s/V, 1
  double current_noise_, voltage_sigma_;                           // A/√Hz, V
};

/// The world's sensors once a second: NAME.current, NAME.voltage, NAME.truth.
class CellSimulator final : public binnacle::Source {
 public:
  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    ComponentSpec spec;
    spec.type = "cell_simulator";
    spec.summary = "A battery cell under a load that repeats each minute, with a current and a voltage sensor.";
    spec.source = "the differential equations of the first-order Thevenin model, integrated in small steps";
    spec.parameters = CellWorld::parameters();
    spec.parameters.push_back(parameter::time("duration").at_least(0).defaults("\"1 h\"").about("of the whole"));
    spec.example = R"json({"soc": 0.9, "soc_sigma": 0.1, "capacity": "2.5 A*h", "r0": "20 mV/A", "r1": "15 mV/A",
      "c1": "2000 A*s/V", "current_noise": "0.05 A/sqrt(Hz)", "voltage_sigma": "5 mV", "ocv_soc": [0, 0.1, 0.5, 0.9, 1],
      "ocv": ["3 V", "3.45 V", "3.7 V", "4.05 V", "4.2 V"], "duration": "60 s"})json";
    return spec;
  }

  explicit CellSimulator(const binnacle::Binding& b)
      : world_(b.parameters()), seconds_(b.parameters().time("duration") / binnacle::nanoseconds(1)) {
    using namespace binnacle;
    ChannelDeclaration current("current"), voltage("voltage"), truth("truth");
    current_ = current.carries(field::rate("current", "A").about("out of the cell"));
    current.max_interval = nanoseconds(1);
    voltage_ = voltage.carries(field::level("voltage", "V").about("between the terminals"));
    soc_ = truth.carries(field::level("soc", "1").about("charge"));
    rc_ = truth.carries(field::level("rc", "V").about("RC voltage"));
    channels_ = {declaration_.emits(std::move(current)), declaration_.emits(std::move(voltage)),
                 declaration_.emits(std::move(truth))};
    memory_ = declaration_.keeps<Memory>();
  }

  binnacle::SourceStatus next(const binnacle::MemoryView& bytes, binnacle::SourceOutput& output) const override {
    Memory& m = bytes[memory_];
    if (m.channel < 0 || m.channel > 2 || m.world.second < 0 || m.world.second >= seconds_ + (m.channel > 0))
      return binnacle::SourceStatus::end;
    if (m.channel == 0) world_.step(m.world);
    binnacle::SampleWriter& out = output.on(channels_[static_cast<std::size_t>(m.channel)]);
    out.t = binnacle::nanoseconds(1) * m.world.second;
    if (m.channel == 0) out.t0 = out.t - binnacle::nanoseconds(1), out[current_] = m.world.current;
    if (m.channel == 1) out[voltage_] = m.world.voltage;
    if (m.channel == 2) out[soc_] = m.world.soc, out[rc_] = m.world.rc;
    m.channel = (m.channel + 1) % 3;
    return binnacle::SourceStatus::sample;
  }

 private:
  struct Memory {
    CellWorld::State world;
    int channel = 0;  // whose turn it is
  };
  void initialise(std::uint64_t seed, const binnacle::MemoryView& bytes) const override {
    bytes[memory_].world = world_.start(seed);
  }

  CellWorld world_;
  std::int64_t seconds_;
  std::array<binnacle::OutputChannel, 3> channels_;
  binnacle::OutputField current_, voltage_, soc_, rc_;
  binnacle::Memory<Memory> memory_;
};
