// SPDX-License-Identifier: Apache-2.0
// Vehicles that move about, a radar that sees most of them and what is not there, and the truth.
#pragma once

#include <binnacle/plugin.hpp>

#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/random.hpp"

/// Targets with white noise as acceleration; a radar at the origin that finds each with a probability, in random order,
/// among clutter that is spread evenly over the disk that it covers, Poisson in number.
class RadarWorld {
 public:
  static constexpr int most_targets = 8;
  static constexpr int most_detections = 32;

  /// Plain memory: the whole state of a simulation.
  struct State {
    Random random{};
    std::int64_t scans = 0;
    double position[most_targets][2] = {}, velocity[most_targets][2] = {};  // north, east [m], [m/s]
    int detections = 0;
    double range[most_detections] = {}, bearing[most_detections] = {};  // m, rad
  };

  static std::vector<binnacle::ParameterSpec> parameters() {
    using namespace binnacle::parameter;
    std::vector<binnacle::ParameterSpec> target;
    target.push_back(vector("position", "m", 2).required().about("mean of it at the start: north, east"));
    target.push_back(vector("velocity", "m/s", 2).required().about("mean of it at the start: north, east"));
    std::vector<binnacle::ParameterSpec> specs;
    specs.push_back(list("targets", object("target", std::move(target))).required().about("one to eight"));
    specs.push_back(number("position_sigma", "m").at_least(0).defaults("0").about("at the start, run by run"));
    specs.push_back(number("velocity_sigma", "m/s").at_least(0).defaults("0").about("at the start, run by run"));
    specs.push_back(number("q", "m/s/sqrt(s)").at_least(0).defaults("0").about("the velocity's random walk"));
    specs.push_back(number("range_sigma", "m").at_least(0).defaults("0").about("of the range's noise"));
    specs.push_back(number("bearing_sigma", "rad").at_least(0).defaults("0").about("of the bearing's noise"));
    specs.push_back(number("found", "1").at_least(0).at_most(1).defaults("1").about("probability of a detection"));
    specs.push_back(number("clutter", "1").at_least(0).at_most(20).defaults("0").about("mean number in a scan"));
    specs.push_back(number("reach", "m").above(0).defaults("\"5 km\"").about("radius of the disk with clutter"));
    specs.push_back(time("interval").above(0).defaults("\"1 s\"").about("from scan to scan"));
    return specs;
  }

  explicit RadarWorld(const binnacle::Parameters& p)
      : position_sigma_(p.number("position_sigma")),
        velocity_sigma_(p.number("velocity_sigma")),
        q_(p.number("q")),
        range_sigma_(p.number("range_sigma")),
        bearing_sigma_(p.number("bearing_sigma")),
        found_(p.number("found")),
        none_(std::exp(-p.number("clutter"))),
        reach_(p.number("reach")),
        interval_(p.time("interval")) {
    for (const auto& element : p.list("targets")) {
      if (targets_ == most_targets) throw binnacle::ComponentError("more than eight targets", "/targets");
      const binnacle::Parameters target(element);
      for (int axis = 0; axis < 2; ++axis) {
        mean_.position[targets_][axis] = target.vector("position")[axis];
        mean_.velocity[targets_][axis] = target.vector("velocity")[axis];
      }
      ++targets_;
    }
    if (targets_ == 0) throw binnacle::ComponentError("there is no target", "/targets");
  }

  int targets() const { return targets_; }
  binnacle::Time interval() const { return interval_; }

  State start(std::uint64_t seed) const {
    State world = mean_;
    world.random = binnacle::random::stream(seed, "radar");
    for (int i = 0; i < targets_; ++i)
      for (int axis = 0; axis < 2; ++axis) {
        world.position[i][axis] += position_sigma_ * normal(world.random);
        world.velocity[i][axis] += velocity_sigma_ * normal(world.random);
      }
    return world;
  }

  /// From one scan to the next. The first comes at time zero, with nobody moved yet.
  void step(State& world) const {
    if (world.scans++ > 0)
      for (int i = 0; i < targets_; ++i)
        for (int axis = 0; axis < 2; ++axis) move(world, i, axis);
    scan(world);
  }

 private:
  /// In small steps: of the continuous model, its position is the integral of its velocity.
  void move(State& world, int i, int axis) const {
    constexpr int parts = 50;
    const double dt = binnacle::seconds(interval_) / parts;
    for (int part = 0; part < parts; ++part) {
      const double before = world.velocity[i][axis];
      world.velocity[i][axis] += q_ * std::sqrt(dt) * normal(world.random);
      world.position[i][axis] += dt * (before + world.velocity[i][axis]) / 2;
    }
  }

  void scan(State& world) const {
    Random& random = world.random;
    world.detections = 0;
    for (int i = 0; i < targets_; ++i) {
      const double u = binnacle::random::uniform(random), range_error = normal(random), bearing_error = normal(random);
      const double north = world.position[i][0], east = world.position[i][1];
      const double range = std::hypot(north, east) + range_sigma_ * range_error;
      if (u < found_ && range > 0) add(world, range, std::atan2(east, north) + bearing_sigma_ * bearing_error);
    }
    // Poisson, by Knuth: how many uniform numbers it takes until their product is below exp(−mean).
    for (double product = binnacle::random::uniform(random); product > none_ && world.detections < most_detections;
         product *= binnacle::random::uniform(random)) {
      const double range = reach_ * std::sqrt(1 - binnacle::random::uniform(random));
      add(world, range, std::numbers::pi * (2 * binnacle::random::uniform(random) - 1));
    }
    for (int k = world.detections - 1; k > 0; --k) {
      const int other = static_cast<int>(random() % static_cast<std::uint64_t>(k + 1));
      std::swap(world.range[k], world.range[other]);
      std::swap(world.bearing[k], world.bearing[other]);
    }
  }

  static void add(State& world, double range, double bearing) {
    world.range[world.detections] = range;
    world.bearing[world.detections] = bearing;
    ++world.detections;
  }

  State mean_;
  int targets_ = 0;
  double position_sigma_, velocity_sigma_, q_;  // m, m/s, m/s/√s
  double range_sigma_, bearing_sigma_;          // m, rad
  double found_, none_, reach_;                 // 1, 1, m
  binnacle::Time interval_;
};

/// The world's scans, NAME.scan, and NAME.truth: north_1, east_1, vn_1, ve_1, north_2, …
class RadarSimulator final : public binnacle::Source {
 public:
  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    ComponentSpec spec;
    spec.type = "radar_simulator";
    spec.summary = "A radar's scans of moving targets, with misses and clutter.";
    spec.source = "Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, 6.2.2";
    spec.parameters = RadarWorld::parameters();
    spec.parameters.push_back(parameter::time("duration").at_least(0).defaults("\"60 s\"").about("of the whole"));
    spec.example = R"json({"targets": [{"position": ["3 km", "0 m"], "velocity": ["-10 m/s", "5 m/s"]}],
      "q": "0.5 m/s/sqrt(s)", "range_sigma": "5 m", "bearing_sigma": "0.3 deg", "found": 0.9, "clutter": 3})json";
    return spec;
  }

  explicit RadarSimulator(const binnacle::Binding& b)
      : world_(b.parameters()), scans_(b.parameters().time("duration") / world_.interval() + 1) {
    using namespace binnacle;
    ChannelDeclaration scan("scan"), truth("truth");
    range_ = scan.carries_per_row(field::level("range", "m").about("from the radar"));
    bearing_ = scan.carries_per_row(field::level("bearing", "rad").about("clockwise from north"));
    scan.max_rows = RadarWorld::most_detections;
    for (int i = 1; i <= world_.targets(); ++i) {
      const auto of_target = [&](const char* name, const char* unit) {
        return field::level(std::string(name).append("_").append(std::to_string(i)), unit).about("of a target");
      };
      targets_.push_back(truth.carries(of_target("north", "m"), of_target("east", "m"), of_target("vn", "m/s"),
                                       of_target("ve", "m/s")));
    }
    scan_ = declaration_.emits(std::move(scan));
    truth_ = declaration_.emits(std::move(truth));
    memory_ = declaration_.keeps<Memory>();
  }

  binnacle::SourceStatus next(const binnacle::MemoryView& bytes, binnacle::SourceOutput& output) const override {
    Memory& m = bytes[memory_];
    if (m.channel < 0 || m.channel > 1 || m.world.scans < 0 || m.world.scans >= scans_ + m.channel)
      return binnacle::SourceStatus::end;
    if (m.channel == 0) world_.step(m.world);
    binnacle::SampleWriter& out = output.on(m.channel == 0 ? scan_ : truth_);
    out.t = (m.world.scans - 1) * world_.interval();
    m.channel == 0 ? write_scan(m.world, out) : write_truth(m.world, out);
    m.channel = 1 - m.channel;
    return binnacle::SourceStatus::sample;
  }

 private:
  struct Memory {
    RadarWorld::State world;
    int channel = 0;  // whose turn it is
  };
  void initialise(std::uint64_t seed, const binnacle::MemoryView& bytes) const override {
    bytes[memory_].world = world_.start(seed);
  }

  void write_scan(const RadarWorld::State& world, binnacle::SampleWriter& out) const {
    for (int k = 0; k < world.detections; ++k) {
      out(k, range_) = world.range[k];
      out(k, bearing_) = world.bearing[k];
    }
    out.rows = world.detections;
  }
  void write_truth(const RadarWorld::State& world, binnacle::SampleWriter& out) const {
    for (std::size_t i = 0; i < targets_.size(); ++i)
      out[targets_[i]] << binnacle::vector_at<2>(world.position[i]), binnacle::vector_at<2>(world.velocity[i]);
  }

  RadarWorld world_;
  std::int64_t scans_;
  binnacle::OutputChannel scan_, truth_;
  binnacle::OutputRowField range_, bearing_;
  std::vector<binnacle::OutputFields<4>> targets_;  // north, east, vn, ve
  binnacle::Memory<Memory> memory_;
};
