// SPDX-License-Identifier: Apache-2.0
// Components that only tests want: a noise estimator that counts in its memory, a nonlinear derived block, a process
// that turns its block into NaN, a measurement with typed refusals, one with as many rows as its sample.
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
  Counting(const Binding& binding, const NoiseBinding&) : temporaries_(binding.parameters().boolean("temporaries")) {}
  std::size_t memory_bytes() const noexcept override { return sizeof(double); }
  void estimate(const Innovation& innovation, std::byte* memory, MatrixView R) const override {
    double& count = *reinterpret_cast<double*>(memory);
    count += 1;
    if (temporaries_) {
      const Eigen::MatrixXd wide = Eigen::MatrixXd::Constant(30, 30, innovation.residual[0]);
      count += 0 * (wide * wide)(0, 0);
    }
    for (int j = 0; j < innovation.rows; ++j)
      for (int i = 0; i < innovation.rows; ++i) R(i, j) = count * innovation.R_nominal(i, j);
  }

 private:
  bool temporaries_;
};

/// y = (x0² , x0 x1): a chain with a state-dependent Jacobian.
class Square : public legacy::DerivedBlock {
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
  explicit Square(const Binding&) { declaration_ = {"vector:2:m^2", 2, {{"x", "m^2"}, {"y", "m^2"}}, {0}}; }
  const DerivedDeclaration& declaration() const noexcept override { return declaration_; }
  Result evaluate(const double* const* x, const legacy::Context&, double* value, const MatrixView* J) const override {
    const double a = x[0][0], b = x[0][1];
    value[0] = a * a;
    value[1] = a * b;
    if (J) {
      J[0](0, 0) = 2 * a;
      J[0](1, 0) = b;
      J[0](1, 1) = a;
    }
    return Result::ok();
  }

 private:
  DerivedDeclaration declaration_;
};

/// Breaks on purpose after `after` seconds.
class Breaking : public legacy::ProcessModel {
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
        dof_(binding.block("x").dof) {
    binding.tell("breaks after", seconds(after_), "s");
    if (!politely_) binding.note("it breaks without a word");
  }
  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }
  Result propagate(const Step& step, const double* const* x, std::byte*,
                   const legacy::ProcessOutput& out) const override {
    const bool breaks = step.t1 > after_;
    if (breaks && politely_) return Result::failed("it is too late");
    for (int i = 0; i < dof_; ++i) out.x_plus[0][i] = breaks ? std::nan("") : x[0][i];
    return Result::ok();
  }

 private:
  Time after_;
  bool politely_;
  int dof_;
  ProcessDeclaration declaration_;
};

/// z = x, refused below 0 (unsupported) and above 100 (invalid); NaN residual at exactly 50.
class Picky : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "picky";
    spec.summary = "Refuses some samples.";
    spec.ports = {reads("x", "vector:1:*", "what is seen")};
    spec.fields = {{"z", "", FieldKind::level, false, false, "the value"}};
    spec.example = R"({"channel": "z", "blocks": {"x": "x"}})";
    return spec;
  }
  explicit Picky(const Binding&) {
    declaration_.max_rows = 1;
    declaration_.read_ports = {0};
    declaration_.memory_bytes = sizeof(double);
  }
  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }
  Result linearize(const SampleView& sample, const SampleView*, const double* const* x, const legacy::Context&,
                   std::byte* memory, legacy::Linearization& out) const override {
    *reinterpret_cast<double*>(memory) += 1;  // kept only when accepted
    if (sample.fields[0] < 0) return Result::unsupported("it is negative");
    if (sample.fields[0] > 100) return Result::invalid("it is too large");
    out.rows = 1;
    out.residual[0] = sample.fields[0] == 50 ? std::nan("") : sample.fields[0] - x[0][0];
    out.H[0](0, 0) = 1;
    out.R(0, 0) = *reinterpret_cast<double*>(memory);
    return Result::ok();
  }

 private:
  MeasurementDeclaration declaration_;
};

/// Every row of the sample sees z = x0 + slope · x1, with a variance of its own; as many rows as there are.
class Rows : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "rows";
    spec.summary = "As many rows as the sample has.";
    spec.ports = {reads("x", "vector:2:*", "what is seen")};
    for (const char* name : {"key", "z", "slope", "variance"})
      spec.fields.push_back({name, "", FieldKind::level, false, true, "per row"});
    spec.example = R"({"channel": "z", "blocks": {"x": "x"}})";
    return spec;
  }
  explicit Rows(const Binding&) {
    declaration_.max_rows = 8;
    declaration_.read_ports = {0};
    declaration_.groups = {{"seen", 0, 0, "m", -1}};
  }
  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }
  Result linearize(const SampleView& sample, const SampleView*, const double* const* x, const legacy::Context&,
                   std::byte*, legacy::Linearization& out) const override {
    out.rows = sample.rows;
    for (int i = 0; i < sample.rows; ++i) {
      const double* row = sample.row_fields + 4 * i;
      out.row_keys[i] = static_cast<std::int64_t>(row[0]);
      out.residual[i] = row[1] - x[0][0] - row[2] * x[0][1];
      out.H[0](i, 0) = 1;
      out.H[0](i, 1) = row[2];
      out.R(i, i) = row[3];
    }
    return Result::ok();
  }

 private:
  MeasurementDeclaration declaration_;
};

}  // namespace

BINNACLE_PLUGIN("probe", "1.0.0", registry) {
  registry.add<Counting>();
  registry.add<Square>();
  registry.add<Breaking>();
  registry.add<Picky>();
  registry.add<Rows>();
}
