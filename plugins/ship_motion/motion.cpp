// SPDX-License-Identifier: Apache-2.0
#include "motion.hpp"

#include <array>

#include <Eigen/Core>

#include "motion_parameters.hpp"

namespace binnacle::ship_motion {

ComponentSpec Motion::spec() {
  ComponentSpec spec;
  spec.type = "motion";
  spec.summary = "Roll, pitch, yaw or heave of a ship in waves: white noise through a shaping filter of order 2 or 4.";
  spec.source =
      "paper 004, section 2; Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23(3), 1978";
  spec.parameters = motion_parameters("@angle");
  spec.ports = {advances("angle", "vector:1:*").about("roll, pitch, yaw, heave"),
                advances("rate", "vector:1:*").about("its rate, in the unit of the angle per second"),
                advances("forcing", "vector:1:*")
                    .optional()
                    .about("order 4: forcing of the angle, in its unit per second squared"),
                advances("forcing_rate", "vector:1:*").optional().about("order 4: rate of the forcing")};
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
    if (binding.port(name).is_bound() != is_fourth)
      throw ComponentError(std::string("the port '") + name +
                               (is_fourth ? "' is needed for order 4" : "' is for order 4, two frequencies"),
                           "/blocks");
  const Eigen::MatrixXd F = filter.dynamics();
  density_ = filter.noise_density();
  const std::array ports{binding.port("angle"), binding.port("rate"), binding.port("forcing"),
                         binding.port("forcing_rate")};
  const auto port = [&](Eigen::Index i) { return ports[static_cast<std::size_t>(i)]; };
  for (Eigen::Index i = 0; i < F.rows(); ++i)
    for (Eigen::Index j = 0; j < F.rows(); ++j)
      if (F(i, j) != 0) F_.push_back({declaration_.couples(port(i), port(j)), F(i, j)});
  const Port last = port(F.rows() - 1);
  q_ = declaration_.adds_noise(last, last);
  declaration_.only_continuous().time_invariant();
}

void Motion::linearized(const ContinuousInput& /*in*/, ContinuousOutput& out) const {
  for (const Element& element : F_) out.F[element.place].as<1, 1>()(0) = element.value;
  out.GQGt[q_].as<1, 1>()(0) = density_;
}

}  // namespace binnacle::ship_motion
