// SPDX-License-Identifier: Apache-2.0
#include "differences.hpp"

#include <cmath>

namespace binnacle::testing {

int offset(const PortStates& ports, std::size_t port) {
  int sum = 0;
  for (std::size_t i = 0; i < port; ++i) sum += ports[i].dof();
  return sum;
}

PortStates moved(PortStates ports, std::size_t port, int component, double by) {
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(ports[port].dof());
  delta[component] = by;
  const std::vector<double> from = ports[port].x;
  ports[port].block->plus(from, delta, ports[port].x);
  return ports;
}

Eigen::MatrixXd differences(const PortStates& ports, std::size_t port, double relative_step, const Function& f) {
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

void compare(const Declared& declared, const PortStates& ports, std::size_t port, const Function& f,
             const std::vector<double>& steps, Complaints& out) {
  Complaints best;
  double least = INFINITY;
  for (const double step : steps) {
    const Eigen::MatrixXd numeric = differences(ports, port, step, f);
    Complaints found;
    double worst = 0;
    for (Eigen::Index j = 0; j < numeric.cols(); ++j)
      for (Eigen::Index i = 0; i < numeric.rows(); ++i) {
        // Differences are divided by the step, and those at half of it are weighted by 4/3.
        const double allowed = declared.allowed(i, j) + 8 * declared.resolution / (step * ports[port].scale[j]);
        const double difference = std::abs(numeric(i, j) - declared.block(i, j));
        const double excess = difference == 0 ? 0 : difference / allowed;
        if (excess <= 1 || excess <= worst) continue;
        worst = std::isfinite(excess) ? excess : 1e300;
        found = {};
        found.add(declared.name, " (", i, ",", j,
                  "): ", declared.undeclared.empty() ? "declared " : declared.undeclared + ", so ",
                  declared.block(i, j), ", by differences ", numeric(i, j), ", allowed ", allowed);
      }
    if (found.empty()) return;
    if (worst < least) least = worst, best = found;
  }
  out.add_all(best);
}

}  // namespace binnacle::testing
