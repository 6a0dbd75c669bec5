// SPDX-License-Identifier: Apache-2.0
// Components that only tests want: a noise estimator that counts in its memory, a nonlinear derived block, a process
// that turns its block into NaN, a measurement with typed refusals, one with as many rows as its sample, one that shows the
// covariance of what it reads.
#include <cmath>
#include <limits>

#include "binnacle/plugin.hpp"

namespace {

using namespace binnacle;

/// R = (1 + calls seen) · nominal; the count is its memory.
class Counting : public NoiseEstimator {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "counting";
    spec.summary = "Trusts a measurement less each time.";
    spec.parameters = {parameter::boolean("temporaries").defaults("false").about("by way of Eigen's heap temporaries")};
    spec.example = "{}";
    return spec;
  }
  Counting(const Binding& binding, const NoiseBinding&)
      : temporaries_(binding.parameters().boolean("temporaries")), count_(declaration_.keeps<double>()) {}
  void estimate(const Innovation& in, MatrixView R) const override {
    double& count = in.memory[count_];
    count += 1;
    if (temporaries_) {
      const Eigen::MatrixXd wide = Eigen::MatrixXd::Constant(30, 30, in.residual[0]);
      count += 0 * (wide * wide)(0, 0);
    }
    for (int j = 0; j < in.rows; ++j)
      for (int i = 0; i < in.rows; ++i) R(i, j) = count * in.R_nominal(i, j);
  }

 private:
  bool temporaries_;
  Memory<double> count_;
};

/// y = (x0² , x0 x1): a chain with a state-dependent Jacobian.
class Square : public DerivedBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "square";
    spec.summary = "Products of a vector's components.";
    spec.ports = {reads("x", "vector:2:*", "the factors")};
    spec.kind = "vector:2:m^2";
    spec.example = R"({"blocks": {"x": "x"}})";
    return spec;
  }
  explicit Square(const Binding& binding) : x_(binding.port("x")) {
    declaration_.yields("vector:2:m^2", 2, {{"x", "m^2"}, {"y", "m^2"}}).reads(x_);
  }
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    const double a = in.x[x_][0], b = in.x[x_][1];
    out.value[0] = a * a;
    out.value[1] = a * b;
    if (const MatrixView J = out.J[x_]) {
      J(0, 0) = 2 * a;
      J(1, 0) = b;
      J(1, 1) = a;
    }
    return Result::ok();
  }

 private:
  Port x_;
};

/// Breaks on purpose after `after` seconds.
class Breaking : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "breaking";
    spec.summary = "Turns its block into NaN.";
    spec.parameters = {parameter::time("after").defaults("1"),
                       parameter::boolean("politely").defaults("false").about("refuse instead")};
    spec.ports = {advances("x", "vector:*:*", "the victim")};
    spec.example = R"({"blocks": {"x": "x"}})";
    return spec;
  }
  explicit Breaking(const Binding& binding)
      : after_(binding.parameters().time("after")),
        politely_(binding.parameters().boolean("politely")),
        x_(binding.port("x")) {
    binding.figure("breaks after", seconds(after_), "s");
    if (!politely_) binding.note("it breaks without a word");
  }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const bool breaks = in.step.t1 > after_;
    if (breaks && politely_) return Result::failed("it is too late");
    for (int i = 0; i < x_.dof(); ++i) out.x[x_][i] = breaks ? std::nan("") : in.x[x_][i];
    return Result::ok();
  }

 private:
  Time after_;
  bool politely_;
  Port x_;
};

/// z = x, refused below 0 (unsupported) and above 100 (invalid); NaN residual at exactly 50.
class Picky : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "picky";
    spec.summary = "Refuses some samples.";
    spec.ports = {reads("x", "vector:1:*", "what is seen")};
    spec.fields = {field::level("z", "").about("the value")};
    spec.example = R"({"channel": "z", "blocks": {"x": "x"}})";
    return spec;
  }
  explicit Picky(const Binding& binding)
      : x_(binding.port("x")), z_(binding.field("z")), calls_(declaration_.keeps<double>()) {
    declaration_.rows(1).reads(x_);
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    double& calls = in.memory[calls_];
    calls += 1;  // kept only when accepted
    const double z = in.sample[z_];
    if (z < 0) return Result::unsupported("it is negative");
    if (z > 100) return Result::invalid("it is too large");
    out.rows = 1;
    out.residual[0] = z == 50 ? std::nan("") : z - in.x[x_][0];
    if (const MatrixView H = out.H[x_]) H(0, 0) = 1;
    out.R(0, 0) = calls;
    return Result::ok();
  }

 private:
  Port x_;
  Field z_;
  Memory<double> calls_;
};

/// Every row of the sample sees z = x0 + slope · x1, with a variance of its own; as many rows as there are.
class Rows : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "rows";
    spec.summary = "As many rows as the sample has.";
    spec.ports = {reads("x", "vector:2:*", "what is seen")};
    for (const char* name : {"key", "z", "slope", "variance"})
      spec.fields.push_back(field::level(name, "").per_row().about("per row"));
    spec.example = R"({"channel": "z", "blocks": {"x": "x"}})";
    return spec;
  }
  explicit Rows(const Binding& binding)
      : x_(binding.port("x")),
        key_(binding.row_field("key")),
        z_(binding.row_field("z")),
        slope_(binding.row_field("slope")),
        variance_(binding.row_field("variance")) {
    declaration_.rows(8).reads(x_).group(rows::like("seen", "m"));
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    out.rows = in.sample.rows;
    const ConstVectorView x = in.x[x_];
    for (int i = 0; i < out.rows; ++i) {
      const double slope = in.sample(i, slope_);
      out.row_keys[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(in.sample(i, key_));
      out.residual[i] = in.sample(i, z_) - x[0] - slope * x[1];
      if (const MatrixView H = out.H[x_]) H(i, 0) = 1, H(i, 1) = slope;
      out.R(i, i) = in.sample(i, variance_);
    }
    return Result::ok();
  }

 private:
  Port x_;
  RowField key_, z_, slope_, variance_;
};

/// r = P between its two ports, column by column; it changes nothing.
class Knowing : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "knowing";
    spec.summary = "Shows the covariance of what it reads.";
    spec.ports = {reads("a", "vector:2:*", "the rows"), reads("b", "vector:2:*", "the columns"),
                  reads("c", "*", "left open").optional()};
    spec.fields = {field::level("z", "1").about("a sample there must be")};
    spec.example = R"({"channel": "z", "blocks": {"a": "a", "b": "b"}})";
    return spec;
  }
  explicit Knowing(const Binding& binding) : a_(binding.port("a")), b_(binding.port("b")), c_(binding.port("c")) {
    declaration_.rows(4).reads(a_).reads(b_).reads(c_).group(rows::like("covariance", "1")).wants_covariance();
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const ConstMatrixView P = in.P(a_, b_);
    if (!P || in.P(a_, c_)) return Result::failed("not the covariance that was asked for");
    out.rows = 4;
    for (int i = 0; i < 4; ++i) out.residual[i] = P(i % 2, i / 2), out.R(i, i) = 1;
    return Result::ok();
  }

 private:
  Port a_, b_, c_;
};

/// x⁺ = x + (v + wind) dt, as the driving input and an auxiliary channel give them. A hole that is bridged costs 4 m².
class Carried : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "carried";
    spec.summary = "Moves by its own speed and by the wind.";
    spec.ports = {advances("x", "vector:1:m", "what is carried")};
    spec.fields = {field::rate("v", "m/s").about("its own speed")};
    spec.inputs = {input("wind", {field::level("w", "m/s").about("its speed")}).optional().about("where it is known"),
                   input("gusts", {field::level("w_1", "m/s").per_row()}).optional().about("to be added, a row each")};
    spec.example = R"({"input": "v", "blocks": {"x": "x"}})";
    return spec;
  }
  explicit Carried(const Binding& binding)
      : x_(binding.port("x")),
        v_(binding.field("v")),
        wind_(binding.input("wind")),
        gusts_(binding.input("gusts")),
        w_(binding.field(wind_, "w")),
        gust_(binding.row_field(gusts_, "w_1")),
        noise_(declaration_.adds_noise(x_, x_)) {}
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    double speed = in.step.samples[0][v_];
    const SampleView& wind = in.auxiliary[wind_];
    if (wind.available) speed += wind[w_];
    if (wind_.is_bound() && !wind.available) in.notes.leave("no wind has come");
    const SampleView& gusts = in.auxiliary[gusts_];
    for (int i = 0; i < gusts.rows; ++i) speed += gusts(i, gust_);
    if (in.step.bridges) in.notes.leave("bridges a hole");
    out.x[x_][0] = in.x[x_][0] + speed * in.step.dt;
    if (const auto Q = out.Qd[noise_]) Q.as<1, 1>()(0, 0) = in.step.bridges ? 4.0 : 0.0;
    return Result::ok();
  }

 private:
  Port x_;
  Field v_;
  Input wind_, gusts_;
  Field w_;
  RowField gust_;
  QBlock noise_;
};

/// x as a derived block, which notes rates which were held over a hole.
class Watchful : public DerivedBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "watchful";
    spec.summary = "The same again.";
    spec.ports = {reads("x", "vector:1:m", "the original")};
    spec.driving_rates = {field::rate("v", "m/s")};
    spec.kind = "vector:1:m";
    spec.example = R"({"blocks": {"x": "x"}})";
    return spec;
  }
  explicit Watchful(const Binding& binding) : x_(binding.port("x")) {
    declaration_.yields_like(binding.block("x")).reads(x_);
  }
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    if (in.u.bridges) in.notes.leave("derived over a hole");
    out.value[0] = in.x[x_][0];
    if (const MatrixView J = out.J[x_]) J(0, 0) = 1;
    return Result::ok();
  }

 private:
  Port x_;
};

/// z = x, noting rates that were held over a hole.
class Wary : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "wary";
    spec.summary = "Looks at a value, and at where it is from.";
    spec.ports = {reads("x", "vector:1:m", "what is seen")};
    spec.fields = {field::level("z", "m").about("the value")};
    spec.example = R"({"channel": "z", "blocks": {"x": "x"}})";
    return spec;
  }
  explicit Wary(const Binding& binding) : x_(binding.port("x")), z_(binding.field("z")) {
    declaration_.rows(1).reads(x_).group(rows::these("z", 1, "m"));
  }
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    if (in.u.bridges) in.notes.leave("seen after a hole");
    out.rows = 1;
    out.residual[0] = in.sample[z_] - in.x[x_][0];
    if (const MatrixView H = out.H[x_]) H(0, 0) = 1;
    out.R(0, 0) = 1;
    return Result::ok();
  }

 private:
  Port x_;
  Field z_;
};

}  // namespace

BINNACLE_PLUGIN("probe", "1.0.0", registry) {
  registry.add<Counting>();
  registry.add<Square>();
  registry.add<Breaking>();
  registry.add<Picky>();
  registry.add<Rows>();
  registry.add<Knowing>();
  registry.add<Carried>();
  registry.add<Watchful>();
  registry.add<Wary>();
}
