// SPDX-License-Identifier: Apache-2.0
// Says that it is linear and time-invariant, and its x⁺ is Φ x to first order only.
// fails: numbers.process.time_invariant
#include "faulty.hpp"

#include <cmath>

namespace faulty::scales_otherwise {

constexpr double rate = 1e-3, density = 0.01;

class Subject final : public ProcessModel {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "process";
    spec.summary = "a slow decay";
    spec.ports = {advances("x", "vector:2:m", "what decays")};
    spec.example = R"({"blocks": {"x": "position"}})";
    return spec;
  }
  explicit Subject(const Binding& binding) : x_(binding.port("x")) {
    phi_ = declaration_.couples(x_, x_, Structure::diagonal);
    q_ = declaration_.adds_noise(x_, x_, Structure::diagonal);
    declaration_.has_both_forms().time_invariant();
  }
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    const double dt = in.step.dt;
    out.x[x_].as() = in.x[x_].as() - (rate * dt) * in.x[x_].as();
    if (const auto phi = out.phi[phi_]) phi.diagonal().setConstant(std::exp(-rate * dt));
    if (const auto Q = out.Qd[q_]) Q.diagonal().setConstant(-density / (2 * rate) * std::expm1(-2 * rate * dt));
    return Result::ok();
  }
  void linearized(const ContinuousInput&, ContinuousOutput& out) const override {
    out.F[phi_].diagonal().setConstant(-rate);
    out.GQGt[q_].diagonal().setConstant(density);
  }

 private:
  Port x_;
  PhiBlock phi_;
  QBlock q_;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("scales_otherwise")); }

}  // namespace faulty::scales_otherwise
