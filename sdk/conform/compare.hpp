// SPDX-License-Identifier: Apache-2.0
// Differences on the manifold, and how near a declared matrix must come to them.
#pragma once

#include <cmath>
#include <functional>
#include <string>

#include <Eigen/Core>

#include "fixture.hpp"

namespace binnacle::conform {

inline PortStates moved(PortStates ports, std::size_t port, int component, double by) {
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(ports[port].dof());
  delta[component] = by;
  ports[port].block->plus(ports[port].x.data(), delta.data(), ports[port].x.data());
  return ports;
}

/// ∂f/∂δ of a port by Richardson's central differences with steps of `relative_step` scales.
inline Eigen::MatrixXd differences(const PortStates& ports, std::size_t port, double relative_step,
                                   const std::function<Eigen::VectorXd(const PortStates&)>& f) {
  Eigen::MatrixXd J;
  for (int j = 0; j < ports[port].dof(); ++j) {
    const double h = relative_step * ports[port].scale[j];
    const auto central = [&](double step) -> Eigen::VectorXd {
      return (f(moved(ports, port, j, step)) - f(moved(ports, port, j, -step))) / (2 * step);
    };
    const Eigen::VectorXd column = (4.0 * central(h / 2) - central(h)) / 3.0;
    if (J.size() == 0) J.resize(column.size(), ports[port].dof());
    J.col(j) = column;
  }
  return J;
}

/// How a declared block differs from differences: the element that is worst at the step where the block is best.
struct Mismatch {
  bool is_there = false;
  Eigen::Index row = 0, column = 0;
  double declared = 0, numeric = 0;
};

/// A sweep over steps, for no single one suits every function: `declared` must agree with one of them.
/// allowed(i, j): absolute.
inline Mismatch compare_over_steps(const PortStates& ports, std::size_t port, const Eigen::MatrixXd& declared,
                                   const std::function<Eigen::VectorXd(const PortStates&)>& f,
                                   const std::function<double(Eigen::Index, Eigen::Index)>& allowed) {
  Mismatch best;
  double least = INFINITY;
  for (const double step : {1e-2, 1e-3, 1e-4, 1e-5}) {
    const Eigen::MatrixXd numeric = differences(ports, port, step, f);
    double worst = 0;
    Mismatch mismatch;
    for (Eigen::Index j = 0; j < numeric.cols(); ++j)
      for (Eigen::Index i = 0; i < numeric.rows(); ++i) {
        const double difference = std::abs(numeric(i, j) - declared(i, j));
        const double excess = difference == 0 ? 0 : difference / allowed(i, j);
        if (!(excess <= 1) && !(excess <= worst)) {
          worst = std::isfinite(excess) ? excess : 1e300;
          mismatch = {true, i, j, declared(i, j), numeric(i, j)};
        }
      }
    if (!mismatch.is_there) return {};
    if (worst < least) least = worst, best = mismatch;
  }
  return best;
}

}  // namespace binnacle::conform
