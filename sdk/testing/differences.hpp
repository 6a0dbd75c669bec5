// SPDX-License-Identifier: Apache-2.0
// Differences on the manifold, and how near a declared matrix comes to them.
#pragma once

#include <functional>
#include <string>

#include "binnacle/testing.hpp"

namespace binnacle::testing {

using Function = std::function<Eigen::VectorXd(const PortStates&)>;

/// The ports with one component of one of them moved.
PortStates moved(PortStates ports, std::size_t port, int component, double by);

/// ∂f/∂δ of a port by Richardson's central differences with steps of `relative_step` scales.
Eigen::MatrixXd differences(const PortStates& ports, std::size_t port, double relative_step, const Function& f);

/// A declared block, and how near it must be: allowed(i, j) and 8 · resolution / step.
struct Declared {
  std::string name;  // "H of 'p'"
  Eigen::MatrixXd block;
  std::string undeclared;  // what is wrong when it differs and nothing was declared; "" : it was declared
  std::function<double(Eigen::Index, Eigen::Index)> allowed;
  double resolution = 0;
};

/// Adds a complaint on the element that is worst at the step where the block is best.
void compare(const Declared& declared, const PortStates& ports, std::size_t port, const Function& f,
             const std::vector<double>& steps, Complaints& out);

}  // namespace binnacle::testing
