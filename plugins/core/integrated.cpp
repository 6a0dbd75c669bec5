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
  spec.parameters = {parameter::vector("q", "@x/sqrt(s)")
                         .sized_by("x")
                         .at_least(0)
                         .about("root of the power spectral density of white noise added to the rate; none if absent")};
  spec.ports = {advances("x", "vector:*:*", "the integral"),
                reads("rate", "vector:*:*", "its rate of change: as long as x, in the unit of x per second")};
  spec.example = R"json({"blocks": {"x": "heading", "rate": "heading_drift"}, "q": "0.1 deg/sqrt(h)"})json";
  spec.surroundings =
      R"json({"blocks": {"heading": {"type": "vector", "size": 1, "unit": "rad", "sigma": 0.1}, "heading_drift": {"type": "vector", "size": 1, "unit": "rad/s", "sigma": 1e-3}}})json";
  return spec;
}

Integrated::Integrated(const Binding& binding) : dof_(binding.block("x").dof) {
  const int rates = binding.block("rate").dof;
  if (rates != dof_)
    throw ComponentError("the rate has " + std::to_string(rates) + " components, the integral " + std::to_string(dof_),
                         "/blocks/rate");
  declaration_.transition = {{0, 1, Structure::diagonal}};
  if (binding.parameters().has("q")) {
    for (const double root : binding.parameters().vector("q")) density_.push_back(root * root);
    declaration_.noise = {{0, 0, Structure::diagonal}};
  }
  declaration_.has_closed_form = false;
  declaration_.has_continuous_form = true;
  declaration_.is_time_invariant = true;
}

void Integrated::linearized(const double* const* /*x*/, const legacy::ContinuousOutput& out) const {
  std::fill_n(out.dynamics[0], dof_, 1.0);
  if (!density_.empty()) std::copy(density_.begin(), density_.end(), out.noise[0]);
}

}  // namespace binnacle::core
