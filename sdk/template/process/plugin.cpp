// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a process model, the random walk of a vector.
#include <binnacle/plugin.hpp>

using namespace binnacle;

/// dx/dt = w with E[w wᵀ] = q² δ(t): Φ = I, which need not be listed, and Qd = q² dt.
class RandomWalk final : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@";
    spec.summary = "A random walk: the rate of a vector is white noise.";
    spec.source = "Gelb (ed.), Applied Optimal Estimation, 1974, section 3.8";
    spec.parameters = {parameter::number("q", "@x/sqrt(s)").at_least(0).required().about("sigma after 1 s")};
    spec.ports = {advances("x", "vector:*:*").about("the vector")};
    spec.example = R"json({"blocks": {"x": "height"}, "q": "0.1 m/sqrt(s)"})json";
    spec.surroundings = R"json({"blocks": {"height": {"type": "vector", "size": 1, "unit": "m", "sigma": "1 m"}}})json";
    return spec;
  }

  explicit RandomWalk(const Binding& b)
      : x_(b.port("x")), Q_(declaration_.adds_noise(x_, x_, Structure::diagonal)), q_(b.parameters().number("q")) {}

  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    out.x[x_].as() = in.x[x_].as();
    if (auto Q = out.Qd[Q_]) Q.diagonal().setConstant(q_ * q_ * in.step.dt);
    return Result::ok();
  }

 private:
  Port x_;
  QBlock Q_;
  double q_;  // unit of x per √s
};

BINNACLE_TYPES("@NAME@");
BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<RandomWalk>(); }
