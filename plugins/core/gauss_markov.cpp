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
  spec.ports = {advances("x", "vector:*:*", "the correlated vector")};
  spec.example = R"json({"blocks": {"x": "gyro_bias"}, "tau": "1 h", "sigma": "0.1 deg/h"})json";
  spec.surroundings =
      R"json({"blocks": {"gyro_bias": {"type": "vector", "size": 3, "unit": "rad/s", "sigma": 5e-7}}})json";
  return spec;
}

GaussMarkov::GaussMarkov(const Binding& binding) {
  const auto tau = binding.parameters().vector("tau");
  const auto sigma = binding.parameters().vector("sigma");
  for (Eigen::Index i = 0; i < tau.size(); ++i) components_.push_back({tau[i], sigma[i] * sigma[i]});
  declaration_.transition = {{0, 0, Structure::diagonal}};
  declaration_.noise = {{0, 0, Structure::diagonal}};
  declaration_.has_continuous_form = true;
  declaration_.is_time_invariant = true;
}

Result GaussMarkov::propagate(const Step& step, const double* const* x, std::byte* /*memory*/,
                              const legacy::ProcessOutput& out) const {
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const auto& [tau, variance] = components_[i];
    const double transition = std::exp(-step.dt / tau);
    out.x_plus[0][i] = transition * x[0][i];
    out.transition[0][i] = transition;
    out.noise[0][i] = -variance * std::expm1(-2.0 * step.dt / tau);
  }
  return Result::ok();
}

void GaussMarkov::linearized(const double* const* /*x*/, const legacy::ContinuousOutput& out) const {
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const auto& [tau, variance] = components_[i];
    out.dynamics[0][i] = -1.0 / tau;
    out.noise[0][i] = 2.0 * variance / tau;
  }
}

}  // namespace binnacle::core
