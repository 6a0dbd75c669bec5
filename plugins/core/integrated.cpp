// SPDX-License-Identifier: Apache-2.0
// The integral of another vector.
#include "integrated.hpp"

#include <algorithm>

namespace binnacle::core {

ComponentSpec Integrated::spec() {
  ComponentSpec spec;
  spec.type = "integrated";
  spec.summary = "A vector whose rate is another vector: position of velocity, angle of a drift.";
  spec.source = "Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23(3), 1978";
  spec.parameters = {
      parameter::vector("q", "@x/sqrt(s)")
          .sized_by("x")
          .at_least(0)
          .about("root of the power spectral density of the white noise added to the rate; default: none")};
  spec.ports = {advances("x", "vector:*:*").about("the integral"),
                reads("rate", "vector:*:*").about("rate of change of x: same size, in the unit of x per second")};
  spec.example = R"json({"blocks": {"x": "heading", "rate": "heading_drift"}, "q": "0.1 deg/sqrt(h)"})json";
  spec.surroundings =
      R"json({"blocks": {"heading": {"type": "vector", "size": 1, "unit": "rad", "sigma": 0.1}, "heading_drift": {"type": "vector", "size": 1, "unit": "rad/s", "sigma": 1e-3}}})json";
  return spec;
}

Integrated::Integrated(const Binding& binding) : x_(binding.port("x")) {
  const Port rate = binding.port("rate");
  if (rate.dof() != x_.dof())
    throw ComponentError("the rate has " + std::to_string(rate.dof()) + " components, the integral " +
                             std::to_string(x_.dof()),
                         "/blocks/rate");
  rate_in_ = declaration_.couples(x_, rate, Structure::diagonal);
  if (binding.parameters().has("q")) {
    for (const double root : binding.parameters().vector("q")) density_.push_back(root * root);
    q_ = declaration_.adds_noise(x_, x_, Structure::diagonal);
  }
  declaration_.only_continuous().time_invariant();
}

void Integrated::linearized(const ContinuousInput& /*in*/, ContinuousOutput& out) const {
  out.F[rate_in_].set_identity();
  if (const BlockView GQGt = out.GQGt[q_]) std::copy(density_.begin(), density_.end(), GQGt.data());
}

}  // namespace binnacle::core
