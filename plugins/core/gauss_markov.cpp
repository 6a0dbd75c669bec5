// SPDX-License-Identifier: Apache-2.0
// First-order Gauss–Markov process.
#include "gauss_markov.hpp"

#include <cmath>

namespace binnacle::core {

ComponentSpec GaussMarkov::spec() {
  ComponentSpec spec;
  spec.type = "gauss_markov";
  spec.summary = "A vector of independent first-order Gauss-Markov processes: exponentially correlated noise.";
  spec.source = "Gelb (ed.), Applied Optimal Estimation, 1974, section 3.8; paper 001, section 3";
  spec.parameters = {
      parameter::vector("tau", "s").sized_by("x").above(0).required().about("correlation time"),
      parameter::vector("sigma", "@x")
          .sized_by("x")
          .at_least(0)
          .required()
          .about("standard deviation in the steady state; the driving noise is 2 sigma^2 / tau"),
  };
  spec.ports = {advances("x", "vector:*:*").about("the correlated vector")};
  spec.example = R"json({"blocks": {"x": "gyro_bias"}, "tau": "1 h", "sigma": "0.1 deg/h"})json";
  spec.surroundings =
      R"json({"blocks": {"gyro_bias": {"type": "vector", "size": 3, "unit": "rad/s", "sigma": 5e-7}}})json";
  return spec;
}

GaussMarkov::GaussMarkov(const Binding& binding)
    : x_(binding.port("x")),
      phi_(declaration_.couples(x_, x_, Structure::diagonal)),
      q_(declaration_.adds_noise(x_, x_, Structure::diagonal)) {
  const auto tau = binding.parameters().vector("tau");
  const auto sigma = binding.parameters().vector("sigma");
  for (Eigen::Index i = 0; i < tau.size(); ++i) components_.push_back({tau[i], sigma[i] * sigma[i]});
  declaration_.has_both_forms().time_invariant();
}

Result GaussMarkov::propagate(const ProcessInput& in, ProcessOutput& out) const {
  const ConstVectorView x = in.x[x_];
  const VectorView next = out.x[x_];
  const BlockView phi = out.phi[phi_], Q = out.Qd[q_];
  for (int i = 0; i < x.size(); ++i) {
    const auto& [tau, variance] = components_[static_cast<std::size_t>(i)];
    const double transition = std::exp(-in.step.dt / tau);
    next[i] = transition * x[i];
    if (phi) phi.diagonal()[i] = transition;
    if (Q) Q.diagonal()[i] = -variance * std::expm1(-2.0 * in.step.dt / tau);
  }
  return Result::ok();
}

void GaussMarkov::linearized(const ContinuousInput& /*in*/, ContinuousOutput& out) const {
  for (int i = 0; i < x_.dof(); ++i) {
    const auto& [tau, variance] = components_[static_cast<std::size_t>(i)];
    out.F[phi_].diagonal()[i] = -1.0 / tau;
    out.GQGt[q_].diagonal()[i] = 2.0 * variance / tau;
  }
}

}  // namespace binnacle::core
