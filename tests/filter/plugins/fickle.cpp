// SPDX-License-Identifier: Apache-2.0
// Components of which any call may throw, and a few that write what may not be. The test lights a fuse: the environment
// variable FICKLE_FUSE holds the address of two numbers: how many calls until one throws, and what it throws.
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>

#include "binnacle/plugin.hpp"

namespace {

using namespace binnacle;

void spark() {
  const char* const text = std::getenv("FICKLE_FUSE");
  if (!text) return;
  long* const fuse = reinterpret_cast<long*>(std::strtoull(text, nullptr, 16));
  if (--fuse[0] != 0) return;
  if (fuse[1] != 0) throw 7;
  throw std::runtime_error("the fuse has blown");
}

/// One number, with an injected error that turns the frame of what remains.
class Value final : public StateBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "fickle_value";
    spec.summary = "Two numbers of which any call may throw.";
    spec.kind = "vector:2:m";
    spec.example = "{}";
    return spec;
  }
  explicit Value(const Binding&) {
    declaration_.kind = "vector:2:m";
    declaration_.stored_size = 2;
    for (const char* name : {"a", "b"}) {
      declaration_.error.push_back({name, "m"});
      Output output;
      output.name = name;
      output.unit = "m";
      declaration_.outputs.push_back(output);
    }
  }
  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    spark();
    for (int i = 0; i < 2; ++i) result[i] = x[i] + delta[i];
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    spark();
    for (int i = 0; i < 2; ++i) delta[i] = y[i] - x[i];
  }
  void read(ConstVectorView x, VectorView outputs) const override {
    spark();
    for (int i = 0; i < 2; ++i) outputs[i] = x[i];
  }
  Result write(ConstVectorView outputs, VectorView x) const override {
    spark();
    for (int i = 0; i < 2; ++i) x[i] = outputs[i];
    return Result::ok();
  }
  bool reset_jacobian(ConstVectorView /*x*/, ConstVectorView delta, MatrixView G) const override {
    spark();
    G(0, 0) = G(1, 1) = 1;
    G(1, 0) = 0.5 * delta[0];
    G(0, 1) = -0.5 * delta[0];
    return true;
  }

 private:
  StateBlockDeclaration declaration_;
};

/// x⁺ = x + v dt, with a memory of the steps taken.
class Move final : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "fickle_move";
    spec.summary = "Moves by a measured speed; any call may throw.";
    spec.parameters = {parameter::text("gives").defaults("\"\"").about("'negative', 'nan_phi' or 'nan_x' after 1 s")};
    spec.ports = {advances("x", "vector:2:*", "what moves")};
    spec.fields = {{"v", "m/s", FieldKind::rate, false, false, "speed"}};
    spec.example = R"({"input": "v", "blocks": {"x": "x"}})";
    return spec;
  }
  explicit Move(const Binding& binding)
      : gives_(binding.parameters().text("gives")), x_(binding.port("x")), v_(binding.field("v")) {
    phi_ = declaration_.couples(x_, x_);
    q_ = declaration_.adds_noise(x_, x_, Structure::diagonal);
    count_ = declaration_.keeps<long>();
  }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    spark();
    ++in.memory[count_];
    double distance = 0;
    for (const auto& sample : in.step.samples) distance += sample[v_] * sample.dt;
    const bool is_late = in.step.t1 > nanoseconds(1);
    for (int i = 0; i < 2; ++i) out.x[x_][i] = in.x[x_][i] + distance;
    if (is_late && gives_ == "nan_x") out.x[x_][1] = std::nan("");
    if (auto phi = out.phi[phi_]) {
      phi.set_identity();
      if (is_late && gives_ == "nan_phi") phi.data()[2] = std::nan("");
    }
    if (auto q = out.Qd[q_])
      for (int i = 0; i < 2; ++i) q.data()[i] = is_late && gives_ == "negative" ? -1e-6 : 0.01 * in.step.dt;
    return Result::ok();
  }

 private:
  void initialise(const MemoryView&) const override { spark(); }

  std::string gives_;
  Port x_;
  Field v_;
  PhiBlock phi_;
  QBlock q_;
  Memory<long> count_;
};

/// ẋ = A x + w with coupled components, discretized by the kernel.
class Decay final : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "fickle_decay";
    spec.summary = "A linear process in its continuous form; any call may throw.";
    spec.ports = {advances("x", "vector:2:*", "what decays")};
    spec.example = R"({"blocks": {"x": "x"}})";
    return spec;
  }
  explicit Decay(const Binding& binding) : x_(binding.port("x")) {
    F_ = declaration_.couples(x_, x_);
    GQGt_ = declaration_.adds_noise(x_, x_, Structure::diagonal);
    declaration_.only_continuous();
  }
  void linearized(const ContinuousInput&, ContinuousOutput& out) const override {
    spark();
    const double F[] = {-0.3, 0.1, 0.2, -0.7};
    for (int i = 0; i < 4; ++i) out.F[F_].data()[i] = F[i];
    out.GQGt[GQGt_].data()[0] = 0.4;
    out.GQGt[GQGt_].data()[1] = 0.1;
  }

 private:
  Port x_;
  PhiBlock F_;
  QBlock GQGt_;
};

/// The sum of both.
class Sum final : public DerivedBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "fickle_sum";
    spec.summary = "The sum of two numbers; any call may throw.";
    spec.kind = "vector:1:m";
    spec.ports = {reads("x", "vector:2:m", "what is added")};
    spec.example = R"({"blocks": {"x": "x"}})";
    return spec;
  }
  explicit Sum(const Binding& binding) : x_(binding.port("x")) {
    declaration_.kind = "vector:1:m";
    declaration_.stored_size = 1;
    declaration_.error = {{"x", "m"}};
    declaration_.reads(x_);
  }
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    spark();
    out.value[0] = in.x[x_][0] + in.x[x_][1];
    if (auto J = out.J[x_]) J(0, 0) = J(0, 1) = 1;
    return Result::ok();
  }

 private:
  Port x_;
};

class See final : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "fickle_see";
    spec.summary = "Sees a number; any call may throw.";
    spec.parameters = {parameter::text("gives").defaults("\"\"").about(
        "'negative', 'nan' or 'asymmetric' noise or 'no rows', not even none, after 1 s")};
    spec.ports = {reads("x", "vector:1:m", "what is seen")};
    spec.fields = {{"z", "m", FieldKind::level, false, false, "as measured"}};
    spec.example = R"({"channel": "z", "blocks": {"x": "x"}})";
    return spec;
  }
  explicit See(const Binding& binding)
      : gives_(binding.parameters().text("gives")), x_(binding.port("x")), z_(binding.field("z")) {
    declaration_.rows(2).reads(x_);
    count_ = declaration_.keeps<long>();
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    spark();
    ++in.memory[count_];
    out.rows = 2;
    for (int i = 0; i < 2; ++i) {
      out.residual[i] = in.sample[z_] - in.x[x_][0];
      if (auto H = out.H[x_]) H(i, 0) = 1;
      out.R(i, i) = 1;
    }
    if (in.sample.t <= nanoseconds(1)) return Result::ok();
    if (gives_ == "negative") out.R(1, 1) = -1;
    if (gives_ == "no rows") out.rows = -1;
    if (gives_ == "nan") out.R(1, 1) = std::nan("");
    if (gives_ == "asymmetric") out.R(0, 1) = 1e-3;
    return Result::ok();
  }

 private:
  void initialise(const MemoryView&) const override { spark(); }

  std::string gives_;
  Port x_;
  Field z_;
  Memory<long> count_;
};

class Trust final : public NoiseEstimator {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "fickle_trust";
    spec.summary = "Trusts as much as nominal; any call may throw.";
    spec.parameters = {parameter::text("gives").defaults("\"\"").about("'negative' or 'nan' after 1 s")};
    spec.example = "{}";
    return spec;
  }
  Trust(const Binding& binding, const NoiseBinding&) : gives_(binding.parameters().text("gives")) {
    declaration_.wants_after().keeps<long>();
  }
  void estimate(const Innovation& in, MatrixView R) const override {
    spark();
    if (in.t <= nanoseconds(1)) return;
    if (gives_ == "negative") R(0, 0) = -4;
    if (gives_ == "nan") R(0, 0) = std::nan("");
  }
  void after(const AfterUpdate&) const override { spark(); }

 private:
  void initialise(const MemoryView&) const override { spark(); }

  std::string gives_;
};

}  // namespace

BINNACLE_PLUGIN("fickle", "1.0.0", registry) {
  registry.add<Value>();
  registry.add<Move>();
  registry.add<Decay>();
  registry.add<Sum>();
  registry.add<See>();
  registry.add<Trust>();
}
