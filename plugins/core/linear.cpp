// SPDX-License-Identifier: Apache-2.0
// Any linear time-invariant process, by its matrices.
#include "linear.hpp"

namespace binnacle::core {

namespace {

/// G: one column per noise; the identity if absent.
Eigen::MatrixXd noise_input(const Parameters& parameters, Eigen::Index dof) {
  if (!parameters.has("G")) return Eigen::MatrixXd::Identity(dof, dof);
  const auto G = parameters.matrix("G");
  if (G.rows() != dof)
    throw ComponentError("G has " + std::to_string(G.rows()) + " rows, the block " + std::to_string(dof) +
                             " components",
                         "/G");
  return G;
}

/// q: one per column of G; one element stands for all.
Eigen::VectorXd noise_density(const Parameters& parameters, Eigen::Index noises) {
  const auto q = parameters.vector("q");
  if (q.size() == 1) return Eigen::VectorXd::Constant(noises, q[0] * q[0]);
  if (q.size() != noises)
    throw ComponentError("q has " + std::to_string(q.size()) + " elements for " + std::to_string(noises) +
                             " noises (columns of G)",
                         "/q");
  return q.cwiseAbs2();
}

}  // namespace

ComponentSpec Linear::spec() {
  ComponentSpec spec;
  spec.type = "linear";
  spec.summary = "Any linear time-invariant process, dx/dt = F x + G w, given by its matrices.";
  spec.source = "Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23(3), 1978";
  spec.parameters = {
      parameter::matrix("F", "1/s")
          .sized_by("x")
          .required()
          .about("dynamics matrix, row by row; plain SI numbers for elements between quantities with different units"),
      parameter::matrix("G", "1").about("noise input matrix, a column per noise; default: the identity"),
      parameter::vector("q", "@x/sqrt(s)")
          .at_least(0)
          .about("root of the power spectral density of each noise, as a list; one element applies to all; default: no "
                 "noise"),
  };
  spec.ports = {advances("x", "vector:*:*").about("the state vector")};
  spec.example = R"json({"blocks": {"x": "roll_motion"}, "F": [[0, 1], [-3.92, -0.885]], "G": [[0], [1]],
    "q": [0.038]})json";
  spec.surroundings =
      R"json({"blocks": {"roll_motion": {"type": "vector", "size": 2, "unit": "rad", "sigma": 0.1}}})json";
  return spec;
}

Linear::Linear(const Binding& binding) : F_(binding.parameters().matrix("F")) {
  const Parameters& parameters = binding.parameters();
  const Port x = binding.port("x");
  const Eigen::Index dof = x.dof();
  if (F_.rows() != dof || F_.cols() != dof)
    throw ComponentError("F must have as many rows and columns as the block has components, " + std::to_string(dof),
                         "/F");
  if (parameters.has("G") && !parameters.has("q"))
    throw ComponentError("G is given, but there is no noise: give 'q'", "/G");
  F_block_ = declaration_.couples(x, x);
  if (parameters.has("q")) {
    const Eigen::MatrixXd G = noise_input(parameters, dof);
    GQG_ = G * noise_density(parameters, G.cols()).asDiagonal() * G.transpose();
    GQG_block_ = declaration_.adds_noise(x, x);
  }
  declaration_.only_continuous().time_invariant();
}

void Linear::linearized(const ContinuousInput& /*in*/, ContinuousOutput& out) const {
  out.F[F_block_].as() = F_;
  if (const BlockView GQGt = out.GQGt[GQG_block_]) GQGt.as() = GQG_;
}

}  // namespace binnacle::core
