// SPDX-License-Identifier: Apache-2.0
#include "motion.hpp"

#include "motion_parameters.hpp"

namespace binnacle::ship_motion {

ComponentSpec Motion::spec() {
  ComponentSpec spec;
  spec.type = "motion";
  spec.summary = "Roll, pitch, yaw or heave of a ship in waves: white noise through a shaping filter of order 2 or 4.";
  spec.source =
      "paper 004, section 2; Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23(3), 1978";
  spec.parameters = motion_parameters("@angle");
  spec.ports = {advances("angle", "vector:1:*", "roll, pitch, yaw, heave"),
                advances("rate", "vector:1:*", "its rate, in the unit of the angle per second"),
                may_advance("forcing", "vector:1:*", "order 4: what drives the angle, in its unit per second squared"),
                may_advance("forcing_rate", "vector:1:*", "order 4: rate of the forcing")};
  spec.example =
      R"json({"blocks": {"angle": "pitch", "rate": "pitch_rate"}, "omega": [1.98], "zeta": [0.2235], "sigma": "0.825 deg"})json";
  spec.surroundings = R"json({"blocks": {"pitch": {"type": "vector", "size": 1, "unit": "rad", "sigma": 0.0144},
    "pitch_rate": {"type": "vector", "size": 1, "unit": "rad/s", "sigma": 0.0285}}})json";
  return spec;
}

Motion::Motion(const Binding& binding) {
  const ShapingFilter filter = read_motion(binding, binding.block("angle").components.front().unit);
  const bool is_fourth = filter.order() == 4;
  for (const char* name : {"forcing", "forcing_rate"})
    if (binding.is_bound(name) != is_fourth)
      throw ComponentError(std::string("the port '") + name +
                               (is_fourth ? "' is needed for order 4" : "' is for order 4, two frequencies"),
                           "/blocks");
  F_ = filter.dynamics();
  density_ = filter.noise_density();
  const int order = static_cast<int>(F_.rows());
  for (int i = 0; i < order; ++i)
    for (int j = 0; j < order; ++j)
      if (F_(i, j) != 0) declaration_.transition.push_back({i, j, Structure::dense});
  declaration_.noise = {{order - 1, order - 1, Structure::dense}};
  declaration_.has_closed_form = false;
  declaration_.has_continuous_form = true;
  declaration_.is_time_invariant = true;
}

void Motion::linearized(const double* const* /*x*/, const legacy::ContinuousOutput& out) const {
  for (std::size_t k = 0; k < declaration_.transition.size(); ++k)
    out.dynamics[k][0] = F_(declaration_.transition[k].to, declaration_.transition[k].from);
  out.noise[0][0] = density_;
}

}  // namespace binnacle::ship_motion
