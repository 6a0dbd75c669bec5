// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a process model, the random walk of a vector.
#include <binnacle/plugin.hpp>

using namespace binnacle;

/// dx/dt = w with E[w wᵀ] = q² δ(t): Φ = I, which need not be listed, and Qd = q² dt.
class RandomWalk final : public legacy::ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@";
    spec.summary = "A vector that wanders: its rate is white noise.";
    spec.source = "Gelb (ed.), Applied Optimal Estimation, 1974, section 3.8";
    spec.parameters = {parameter::number("q", "@x/sqrt(s)").at_least(0).required().about("sigma after 1 s")};
    spec.ports = {advances("x", "vector:*:*", "the vector that wanders")};
    spec.example = R"json({"blocks": {"x": "height"}, "q": "0.1 m/sqrt(s)"})json";
    spec.surroundings = R"json({"blocks": {"height": {"type": "vector", "size": 1, "unit": "m", "sigma": "1 m"}}})json";
    return spec;
  }

  explicit RandomWalk(const Binding& b) : size_(b.block("x").dof), q_(b.parameters().number("q")) {
    declaration_.noise = {{0, 0, Structure::diagonal}};
  }

  const ProcessDeclaration& declaration() const noexcept override { return declaration_; }

  Result propagate(const Step& step, const double* const* x, std::byte*,
                   const legacy::ProcessOutput& out) const override {
    vector_at(out.x_plus[0], size_) = vector_at(x[0], size_);
    vector_at(out.noise[0], size_).setConstant(q_ * q_ * step.dt);
    return Result::ok();
  }

 private:
  ProcessDeclaration declaration_;
  int size_;
  double q_;  // unit of x per √s
};

BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<RandomWalk>(); }
