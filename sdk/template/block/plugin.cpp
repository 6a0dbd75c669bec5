// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a state block, a heading that wraps, and the compass that sees it.
#include <binnacle/plugin.hpp>

#include <cmath>
#include <numbers>

using namespace binnacle;

namespace {

/// The same direction in [−π, π].
double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

}  // namespace

/// Stored: the heading ψ in [−π, π]. Error: δ with ψ_true = wrapped(ψ + δ). Kind: `@NAME@`.
class Heading final : public StateBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@";
    spec.summary = "A heading: an angle that wraps.";
    spec.source = "Sola, Deray, Atchuthan, A micro Lie theory for state estimation in robotics, 2018, appendix A";
    spec.kind = "@NAME@";
    spec.example = R"json({"init": {"heading": "170 deg"}, "sigma": "10 deg"})json";
    return spec;
  }

  explicit Heading(const Binding&) {
    declaration_.kind = "@NAME@";
    declaration_.stored_size = 1;
    declaration_.error = {{"heading", "rad"}};
    declaration_.error_display_unit = "deg";
    declaration_.outputs = {{"heading", "rad", "deg", true, true, "clockwise from north"}};
  }

  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }

  void plus(const double* x, const double* delta, double* result) const override { *result = wrapped(*x + *delta); }
  void minus(const double* y, const double* x, double* delta) const override { *delta = wrapped(*y - *x); }
  void read(const double* x, double* outputs) const override { *outputs = *x; }
  Result write(const double* outputs, double* x) const override {
    if (!std::isfinite(*outputs)) return Result::invalid("the heading is not finite");
    *x = wrapped(*outputs);
    return Result::ok();
  }

 private:
  StateBlockDeclaration declaration_;
};

/// z = ψ + v, so r = z ⊟ ψ̂ and H = 1. A kind of one's own needs a model that has a port for it.
class Compass final : public legacy::MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@_compass";
    spec.summary = "A compass: the heading, directly.";
    spec.parameters = {parameter::number("sigma", "rad").above(0).required().about("of the white noise")};
    spec.ports = {reads("heading", "@NAME@", "what it sees")};
    spec.fields = {{"heading", "rad", FieldKind::level, false, false, "clockwise from north"}};
    spec.example = R"json({"channel": "compass", "blocks": {"heading": "heading"}, "sigma": "5 deg"})json";
    spec.surroundings = R"json({"blocks": {"heading": {"type": "@NAME@", "init": {"heading": "170 deg"},
      "sigma": "10 deg"}}, "sample": {"heading": -3.05}})json";
    return spec;
  }

  explicit Compass(const Binding& b) : sigma_(b.parameters().number("sigma")) {
    declaration_.max_rows = 1;
    declaration_.read_ports = {0};
    declaration_.groups = {{"heading", 0, 1, "rad", 0}};
  }

  const MeasurementDeclaration& declaration() const noexcept override { return declaration_; }

  Result linearize(const SampleView& sample, const SampleView*, const double* const* x, const legacy::Context&,
                   std::byte*, legacy::Linearization& out) const override {
    if (!std::isfinite(sample.fields[0])) return Result::invalid("the heading is not finite");
    out.rows = 1;
    out.residual[0] = wrapped(sample.fields[0] - x[0][0]);
    out.H[0](0, 0) = 1;
    out.R(0, 0) = sigma_ * sigma_;
    return Result::ok();
  }

 private:
  MeasurementDeclaration declaration_;
  double sigma_;  // rad
};

BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) {
  registry.add<Heading>();
  registry.add<Compass>();
}
