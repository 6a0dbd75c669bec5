// SPDX-License-Identifier: Apache-2.0
// The least value of a function within bounds, by NLopt; and what its curvature there leaves open.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace binnacle::tune {

struct Function {
  /// With `gradient` null: the value alone. Infinite where there is none.
  std::function<double(const std::vector<double>& u, double* gradient)> value;
  std::vector<double> lower, upper;
  bool has_gradient = true;
  std::vector<double> weights;  // the optimizer sees weight × u; empty: u
  double tolerance = 0;         // of the value
};

struct Minimum {
  std::vector<double> u;
  double value = 0, first = 0;  // first: at the start
  int evaluations = 0;
  bool is_converged = false;
};

/// L-BFGS (Liu and Nocedal) with a gradient, else BOBYQA (Powell).
Minimum minimize(const Function& function, const std::vector<double>& start, int most_evaluations);

/// Second derivatives: by central differences of gradients, or of values where there is none.
Eigen::MatrixXd curvature(const Function& function, const std::vector<double>& u, double step);

/// A direction of u in which the value rises by less than ½ (s / limit)² over a length s.
struct OpenDirection {
  Eigen::VectorXd direction;  // of length 1
  double sigma = 0;           // infinite where it does not rise
  std::vector<std::size_t> involved;
};

std::vector<OpenDirection> open_directions(const Eigen::MatrixXd& curvature, double limit);

}  // namespace binnacle::tune
