// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a derived block, the difference of two vectors.
#include <binnacle/plugin.hpp>

using namespace binnacle;

/// y = to − from + offset, so J = I with respect to `to` and −I with respect to `from`.
class Difference final : public DerivedBlock {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@";
    spec.summary = "The difference of two vectors: a baseline, a relative velocity, a bias between two sensors.";
    spec.kind = "vector:*:*";
    spec.parameters = {parameter::vector("offset", "@to").sized_by("to").defaults("0").about("added to it")};
    spec.ports = {reads("from", "vector:*:*").about("what is subtracted"),
                  reads("to", "vector:*:*").about("what it is subtracted from")};
    spec.example = R"json({"blocks": {"from": "base", "to": "rover"}, "offset": ["0 m", "0.5 m"]})json";
    spec.surroundings = R"json({"blocks": {"base": {"type": "vector", "size": 2, "unit": "m", "sigma": "1 m"},
      "rover": {"type": "vector", "size": 2, "unit": "m", "init": {"x0": "10 m", "x1": "20 m"}, "sigma": "1 m"}}})json";
    return spec;
  }

  explicit Difference(const Binding& b)
      : from_(b.port("from")), to_(b.port("to")), offset_(b.parameters().vector("offset")) {
    const PortBinding& from = b.block("from");
    const PortBinding& to = b.block("to");
    if (from.kind != to.kind) throw ComponentError("'from' is a " + from.kind + ", 'to' a " + to.kind, "/blocks/from");
    declaration_.yields_like(to).reads(from_).reads(to_);
  }

  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override {
    out.value.as() = in.x[to_].as() - in.x[from_].as() + offset_;
    if (auto J = out.J[from_]) J.as().diagonal().setConstant(-1);
    if (auto J = out.J[to_]) J.as().diagonal().setConstant(1);
    return Result::ok();
  }

 private:
  Port from_, to_;
  Eigen::VectorXd offset_;
};

BINNACLE_TYPES("@NAME@");
BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<Difference>(); }
