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
    declaration_.outputs = {output("heading", "rad").shown_in("deg").angle().about("clockwise from north")};
  }

  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }

  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    result[0] = wrapped(x[0] + delta[0]);
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override { delta[0] = wrapped(y[0] - x[0]); }
  void read(ConstVectorView x, VectorView outputs) const override { outputs[0] = x[0]; }
  Result write(ConstVectorView outputs, VectorView x) const override {
    if (!std::isfinite(outputs[0])) return Result::invalid("the heading is not finite");
    x[0] = wrapped(outputs[0]);
    return Result::ok();
  }

 private:
  StateBlockDeclaration declaration_;
};

/// z = ψ + v, so r = z ⊟ ψ̂ and H = 1. A kind of one's own needs a model that has a port for it.
class Compass final : public MeasurementModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@_compass";
    spec.summary = "A compass: the heading, directly.";
    spec.parameters = {parameter::number("sigma", "rad").above(0).required().about("of the white noise")};
    spec.ports = {reads("heading", "@NAME@").about("what it sees")};
    spec.fields = {field::level("heading", "rad").about("clockwise from north")};
    spec.example = R"json({"channel": "compass", "blocks": {"heading": "heading"}, "sigma": "5 deg"})json";
    spec.surroundings = R"json({"blocks": {"heading": {"type": "@NAME@", "init": {"heading": "170 deg"},
      "sigma": "10 deg"}}, "sample": {"heading": -3.05}})json";
    return spec;
  }

  explicit Compass(const Binding& b)
      : heading_(b.port("heading")), z_(b.field("heading")), sigma_(b.parameters().number("sigma")) {
    declaration_.rows(1).reads(heading_).group(rows::of("heading", heading_));
  }

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    const double z = in.sample[z_];
    if (!std::isfinite(z)) return Result::invalid("the heading is not finite");
    out.rows = 1;
    out.residual[0] = wrapped(z - in.x[heading_][0]);
    if (auto H = out.H[heading_]) H(0, 0) = 1;
    out.R(0, 0) = sigma_ * sigma_;
    return Result::ok();
  }

 private:
  Port heading_;
  Field z_;
  double sigma_;  // rad
};

BINNACLE_TYPES("@NAME@ @NAME@_compass");
BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) {
  registry.add<Heading>();
  registry.add<Compass>();
}
