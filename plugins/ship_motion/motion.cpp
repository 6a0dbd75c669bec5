// SPDX-License-Identifier: Apache-2.0
#include "motion.hpp"

#include <Eigen/LU>

namespace binnacle::ship_motion {

namespace {

enum Port { angle, rate, forcing, forcing_rate };

Eigen::MatrixXd dynamics(const Eigen::VectorXd& omega, const Eigen::VectorXd& zeta) {
  const Eigen::Index order = 2 * omega.size();
  Eigen::MatrixXd F = Eigen::MatrixXd::Zero(order, order);
  for (Eigen::Index k = 0; k < omega.size(); ++k) {
    F(2 * k, 2 * k + 1) = 1;
    F(2 * k + 1, 2 * k) = -omega[k] * omega[k];
    F(2 * k + 1, 2 * k + 1) = -2 * zeta[k] * omega[k];
    if (2 * k + 2 < order) F(2 * k + 1, 2 * k + 2) = 1;
  }
  return F;
}

/// Steady variance of the first state for noise of unit density on the last: F P + P Fᵀ + g gᵀ = 0, by Kronecker products.
double steady_variance(const Eigen::MatrixXd& F) {
  const Eigen::Index n = F.rows();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n * n, n * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index k = 0; k < n; ++k) {
        A(i + n * j, k + n * j) += F(i, k);
        A(i + n * j, i + n * k) += F(j, k);
      }
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n * n);
  b[n * n - 1] = -1;
  return A.partialPivLu().solve(b)[0];
}

}  // namespace

ComponentSpec Motion::spec() {
  ComponentSpec spec;
  spec.type = "motion";
  spec.summary = "Roll, pitch, yaw or heave of a ship in waves: white noise through a shaping filter of order 2 or 4.";
  spec.source =
      "paper 004, section 2; Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23(3), 1978";
  spec.parameters = {
      parameter::vector("omega", "rad/s").above(0).required().about("natural frequency, a list; two for order 4"),
      parameter::vector("zeta", "1").above(0).required().about("damping ratio, one for each frequency"),
      parameter::number("sigma", "@angle")
          .at_least(0)
          .required()
          .about("standard deviation of the angle in the steady state"),
  };
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
  const Eigen::VectorXd omega = binding.parameters().vector("omega"), zeta = binding.parameters().vector("zeta");
  if (omega.size() != 1 && omega.size() != 2)
    throw ComponentError("one frequency makes order 2, two make order 4; found " + std::to_string(omega.size()),
                         "/omega");
  if (zeta.size() != omega.size()) throw ComponentError("one damping ratio for each frequency", "/zeta");
  const bool is_fourth = omega.size() == 2;
  for (const char* name : {"forcing", "forcing_rate"})
    if (binding.is_bound(name) != is_fourth)
      throw ComponentError(std::string("the port '") + name +
                               (is_fourth ? "' is needed for order 4" : "' is for order 4, two frequencies"),
                           "/blocks");
  F_ = dynamics(omega, zeta);
  const double sigma = binding.parameters().number("sigma");
  density_ = sigma * sigma / steady_variance(F_);
  const int order = static_cast<int>(F_.rows());
  for (int i = 0; i < order; ++i)
    for (int j = 0; j < order; ++j)
      if (F_(i, j) != 0) declaration_.transition.push_back({i, j, Structure::dense});
  declaration_.noise = {{order - 1, order - 1, Structure::dense}};
  declaration_.has_closed_form = false;
  declaration_.has_continuous_form = true;
  declaration_.is_time_invariant = true;
}

void Motion::linearized(const double* const* /*x*/, const ContinuousOutput& out) const {
  for (std::size_t k = 0; k < declaration_.transition.size(); ++k)
    out.dynamics[k][0] = F_(declaration_.transition[k].to, declaration_.transition[k].from);
  out.noise[0][0] = density_;
}

}  // namespace binnacle::ship_motion
