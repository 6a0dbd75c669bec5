// SPDX-License-Identifier: Apache-2.0
// Healthy components, from which a faulty one inherits to break exactly one rule. A fault is a source of this folder:
// `// fails: CHECK [STATUS]` names the check that finds it ("nothing": none does; "verdict": nothing is bad, and yet it does not
// conform, for none of the checks of numbers could be tried), and a namespace that bears the source's name has add(), which
// registers the type of that name, or those of `// types: …`.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include <Eigen/Geometry>

#include "binnacle/plugin.hpp"
#include "binnacle/view.hpp"

namespace faulty {

using namespace binnacle;

/// Position and velocity in a plane: p' = v, v' = white noise of density q.
class Process : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "process";
    spec.summary = "constant velocity in a plane";
    spec.parameters = {
        parameter::number("q", "m^2/s^3").at_least(0).defaults("0.01").about("density of the acceleration")};
    spec.ports = {advances("p", "vector:2:m", "position"), advances("v", "vector:2:m/s", "velocity")};
    spec.example = R"({"blocks": {"p": "position", "v": "velocity"}})";
    return spec;
  }
  explicit Process(const Binding& binding)
      : p(binding.port("p")), v(binding.port("v")), q(binding.parameters().number("q")) {
    phi_pv = declaration_.couples(p, v, Structure::diagonal);
    q_pp = declaration_.adds_noise(p, p, Structure::diagonal);
    q_vv = declaration_.adds_noise(v, v, Structure::diagonal);
    q_pv = declaration_.adds_noise(p, v, Structure::diagonal);
  }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const double dt = in.step.dt;
    for (int i = 0; i < 2; ++i) {
      out.x[p][i] = in.x[p][i] + in.x[v][i] * dt;
      out.x[v][i] = in.x[v][i];
      set(out.phi, phi_pv, i, dt);
      set(out.Qd, q_pp, i, q * dt * dt * dt / 3);
      set(out.Qd, q_vv, i, q * dt);
      set(out.Qd, q_pv, i, q * dt * dt / 2);
    }
    return Result::ok();
  }

 protected:
  /// The i-th element of a diagonal block; nothing where none is wanted.
  template <class Table, class Handle>
  static void set(const Table& table, Handle handle, int i, double value) {
    if (double* block = diagonal(table, handle)) block[i] = value;
  }
  template <class Table, class Handle>
  static double* diagonal(const Table& table, Handle handle) {
    return table[handle].data();
  }

  Port p, v;
  PhiBlock phi_pv;
  QBlock q_pp, q_vv, q_pv;
  double q = 0;
};

/// The range to a beacon.
class Measurement : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "measurement";
    spec.summary = "range to a beacon";
    spec.parameters = {parameter::number("sigma", "m").above(0).defaults("0.5").about("of the range")};
    spec.ports = {reads("p", "vector:2:m", "position")};
    spec.fields = {{"range", "m", FieldKind::level, false, false, "to the beacon"}};
    spec.example = R"({"channel": "ranges", "blocks": {"p": "position"}})";
    return spec;
  }
  explicit Measurement(const Binding& binding)
      : p(binding.port("p")), range(binding.field("range")), sigma(binding.parameters().number("sigma")) {
    declaration_.rows(1).reads(p).group(rows::these("range", 1, "m"));
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    return see(in.x[p][0] + 300, in.x[p][1] + 200, in.sample[range], out);
  }

 protected:
  /// The range from the beacon, (dx, dy) away.
  Result see(double dx, double dy, double measured, MeasurementOutput& out) const {
    const double distance = std::hypot(dx, dy);
    if (!std::isfinite(measured)) return Result::invalid("the range is not a number");
    out.rows = 1;
    out.residual[0] = measured - distance;
    if (const auto H = out.H[p]) {
      H(0, 0) = dx / distance;
      H(0, 1) = dy / distance;
    }
    out.R(0, 0) = sigma * sigma;
    return Result::ok();
  }

  Port p;
  Field range;
  double sigma = 0;
};

/// A point on the lever arm of a pendulum: a bent function of a vector.
class Derived : public DerivedBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "derived";
    spec.summary = "a bent plane";
    spec.ports = {reads("p", "vector:2:m", "position")};
    spec.kind = "vector:2:m";
    spec.example = R"({"blocks": {"p": "position"}})";
    return spec;
  }
  explicit Derived(const Binding& binding) : p(binding.port("p")) {
    declaration_.yields("vector:2:m", 2, {{"x", "m"}, {"y", "m"}}).reads(p);
  }
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    const auto x = in.x[p];
    out.value[0] = x[0] + 0.01 * x[1] * x[1];
    out.value[1] = 2 * x[1];
    if (const auto J = out.J[p]) {
      J(0, 0) = 1;
      J(0, 1) = 0.02 * x[1];
      J(1, 1) = 2;
    }
    return Result::ok();
  }

 protected:
  Port p;
};

/// A direction in space as a quaternion (w, x, y, z), its error a rotation vector from the left.
class Block : public StateBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "block";
    spec.summary = "a rotation";
    spec.kind = "faulty_rotation";
    spec.example = R"({"init": {"a": 0.1, "b": 0.2, "c": 0.3}, "sigma": 0.1})";
    return spec;
  }
  explicit Block(const Binding&) {
    declared.kind = "faulty_rotation";
    declared.stored_size = 4;
    declared.error = {{"x", "rad"}, {"y", "rad"}, {"z", "rad"}};
    for (const char* name : {"a", "b", "c"})
      declared.outputs.push_back({name, "rad", "", false, true, "rotation vector"});
  }
  const StateBlockDeclaration& declaration() const noexcept override { return declared; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    const Eigen::Quaterniond q = exponential(delta) * load(x);
    store(q.normalized(), result);
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    logarithm(load(y) * load(x).conjugate(), delta);
  }
  void read(ConstVectorView x, VectorView outputs) const override { logarithm(load(x), outputs); }
  Result write(ConstVectorView outputs, VectorView x) const override {
    store(exponential(outputs), x);
    return Result::ok();
  }
  bool reset_jacobian(ConstVectorView /*x*/, ConstVectorView d, MatrixView G) const override {
    G.as<3, 3>() << 1, -d[2] / 2, d[1] / 2, d[2] / 2, 1, -d[0] / 2, -d[1] / 2, d[0] / 2, 1;
    return true;
  }

 protected:
  static Eigen::Quaterniond load(ConstVectorView x) { return {x[0], x[1], x[2], x[3]}; }
  static void store(const Eigen::Quaterniond& q, VectorView x) {
    x[0] = q.w(), x[1] = q.x(), x[2] = q.y(), x[3] = q.z();
  }
  static Eigen::Quaterniond exponential(ConstVectorView v) {
    const Eigen::Vector3d w(v[0], v[1], v[2]);
    const double angle = w.norm(), s = angle > 1e-9 ? std::sin(angle / 2) / angle : 0.5;
    return {std::cos(angle / 2), s * w[0], s * w[1], s * w[2]};
  }
  static void logarithm(Eigen::Quaterniond q, VectorView v) {
    if (q.w() < 0) q.coeffs() *= -1;
    const double sine = q.vec().norm();
    const double factor = sine > 1e-12 ? 2 * std::atan2(sine, q.w()) / sine : 2;
    for (int i = 0; i < 3; ++i) v[i] = factor * q.vec()[i];
  }
  StateBlockDeclaration declared;
};

/// R as an exponential average of r² − H P Hᵀ, no less than a hundredth of the nominal one.
class Noise : public NoiseEstimator {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "noise";
    spec.summary = "exponential average";
    spec.parameters = {
        parameter::number("gain", "1").above(0).at_most(0.05).defaults("0.02").about("of a new innovation")};
    spec.example = "{}";
    return spec;
  }
  Noise(const Binding& binding, const NoiseBinding& noise)
      : gain(binding.parameters().number("gain")),
        averages(declaration_.keeps_array<double>(static_cast<std::size_t>(noise.max_rows))),
        has_begun(declaration_.keeps<double>()) {}
  void estimate(const Innovation& in, MatrixView R) const override {
    for (int i = 0; i < in.rows; ++i) {
      const double nominal = in.R_nominal(i, i);
      const double seen = in.residual[i] * in.residual[i] - in.HPHt(i, i);
      double& average = in.memory[averages][static_cast<std::size_t>(i)];
      if (in.memory[has_begun] == 0) average = nominal;
      if (std::isfinite(seen)) average += gain * (seen - average);
      R(i, i) = std::max(average, 0.01 * nominal);
    }
    in.memory[has_begun] = 1;
  }

 protected:
  double gain = 0;
  MemoryArray<double> averages;
  Memory<double> has_begun;
};

/// A sawtooth with noise made of a hash.
class Source : public binnacle::Source {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "source";
    spec.summary = "a noisy sawtooth";
    spec.parameters = {parameter::integer("samples").at_least(1).at_most(1000000).defaults("200").about("how many")};
    spec.example = "{}";
    return spec;
  }
  explicit Source(const Binding& binding) : samples(binding.parameters().integer("samples")) {
    ChannelDeclaration of_values;
    value = of_values.carries(field::level("value", "m").about("of the sawtooth"));
    channel = declaration_.emits(std::move(of_values));
    place = declaration_.keeps<State>();
  }
  SourceStatus next(const MemoryView& memory, SourceOutput& output) const override {
    State& state = memory[place];
    if (state.count < 0 || state.count >= samples) return SourceStatus::end;
    const std::uint64_t hash = (state.seed + static_cast<std::uint64_t>(state.count)) * 0x9e3779b97f4a7c15ull;
    SampleWriter& out = output.on(channel);
    out.t = 1'000'000'000 + state.count * 10'000'000;
    out[value] = static_cast<double>(state.count % 10) + static_cast<double>(hash >> 40) * 1e-9;
    ++state.count;
    return SourceStatus::sample;
  }

 protected:
  struct State {
    std::uint64_t seed = 0;
    std::int64_t count = 0;
  };
  void initialise(std::uint64_t seed, const MemoryView& memory) const override { memory[place].seed = seed; }

  std::int64_t samples = 0;
  OutputChannel channel;
  OutputField value;
  Memory<State> place;
};

/// A running mean.
class Transform : public binnacle::Transform {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "transform";
    spec.summary = "a running mean";
    spec.parameters = {parameter::number("gain", "1").above(0).at_most(1).defaults("0.1").about("of a new sample")};
    spec.inputs = {input("values", {field::level("value", "m").about("to be averaged")}).about("what is averaged")};
    spec.example = R"({"input": "values"})";
    return spec;
  }
  explicit Transform(const Binding& binding)
      : gain(binding.parameters().number("gain")), value(binding.field(binding.input("values"), "value")) {
    ChannelDeclaration of_means;
    mean = of_means.carries(field::level("mean", "m").about("so far"));
    channel = declaration_.emits(std::move(of_means));
    so_far = declaration_.keeps<double>();
  }
  void on(const TransformInput& in, Emitter& emitter) const override {
    double& average = in.memory[so_far];
    average += gain * (in.sample[value] - average);
    SampleWriter& out = emitter.on(channel);
    out.t = in.sample.t;
    out[mean] = average;
    emitter.emit(channel);
  }

 protected:
  double gain = 0;
  Field value;
  OutputChannel channel;
  OutputField mean;
  Memory<double> so_far;
};

/// A component's spec under the name of its fault.
template <class Component>
ComponentSpec named(const char* type) {
  ComponentSpec spec = Component::spec();
  spec.type = type;
  return spec;
}

/// For a library that brings them all as they are.
inline void register_all(Registry& registry) {
  registry.add<Process>();
  registry.add<Measurement>();
  registry.add<Derived>();
  registry.add<Block>();
  registry.add<Noise>();
  registry.add<Source>();
  registry.add<Transform>();
}

/// What a library's faults are, in a table that the build makes of their sources.
struct Fault {
  const char* name;
  void (*add)(Registry& registry);
};

}  // namespace faulty
