// SPDX-License-Identifier: Apache-2.0
#include "optimizer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <nlopt.hpp>

#include "algebra/decompositions.hpp"

namespace binnacle::tune {

namespace {

/// What NLopt is shown: the best that was seen is kept, for L-BFGS may end elsewhere.
struct Watched {
  const Function& function;
  std::vector<double> weights;
  Minimum best;
};

double watched_cost(const std::vector<double>& z, std::vector<double>& gradient, void* data) {
  auto& watched = *static_cast<Watched*>(data);
  auto u = z;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] /= watched.weights[i];
  const double value = watched.function.value(u, gradient.empty() ? nullptr : gradient.data());
  if (watched.best.evaluations++ == 0) watched.best.first = value;
  if (value < watched.best.value) {
    watched.best.value = value;
    watched.best.u = u;
  }
  if (!std::isfinite(value)) {
    std::ranges::fill(gradient, 0.0);
    return 1e30;
  }
  for (std::size_t i = 0; i < gradient.size(); ++i) gradient[i] /= watched.weights[i];
  return value;
}

}  // namespace

Minimum minimize(const Function& function, const std::vector<double>& start, int most_evaluations) {
  std::vector<double> weights = function.weights;
  weights.resize(start.size(), 1.0);
  Watched watched{function, weights, {start, std::numeric_limits<double>::infinity(), 0, 0, false}};
  const auto weighted = [&](std::vector<double> values) {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] *= weights[i];
    return values;
  };
  nlopt::opt optimizer(function.has_gradient ? nlopt::LD_LBFGS : nlopt::LN_BOBYQA, static_cast<unsigned>(start.size()));
  optimizer.set_min_objective(watched_cost, &watched);
  optimizer.set_lower_bounds(weighted(function.lower));
  optimizer.set_upper_bounds(weighted(function.upper));
  optimizer.set_ftol_abs(function.tolerance);
  optimizer.set_maxeval(most_evaluations);
  if (!function.has_gradient) {
    optimizer.set_initial_step(0.5);
    optimizer.set_xtol_abs(1e-3);
  }
  auto z = weighted(start);
  double value = 0;
  try {
    const auto result = optimizer.optimize(z, value);
    watched.best.is_converged = result > 0 && result != nlopt::MAXEVAL_REACHED;
  } catch (const nlopt::roundoff_limited&) {
    watched.best.is_converged = true;
  } catch (const std::runtime_error&) {
    // No descent along a line: at the end, or nowhere to go. What follows looks at the curvature.
  }
  return std::move(watched.best);
}

Eigen::MatrixXd curvature(const Function& function, const std::vector<double>& u, double step) {
  const auto n = static_cast<Eigen::Index>(u.size());
  Eigen::MatrixXd H(n, n);
  const auto at = [&](Eigen::Index i, double by, Eigen::Index j = -1, double by_j = 0) {
    auto moved = u;
    moved[static_cast<std::size_t>(i)] += by;
    if (j >= 0) moved[static_cast<std::size_t>(j)] += by_j;
    return moved;
  };
  if (function.has_gradient) {
    Eigen::VectorXd above(n), below(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      function.value(at(i, step), above.data());
      function.value(at(i, -step), below.data());
      H.col(i) = (above - below) / (2 * step);
    }
    return 0.5 * (H + H.transpose());
  }
  const double here = function.value(u, nullptr);
  for (Eigen::Index i = 0; i < n; ++i) {
    H(i, i) = (function.value(at(i, step), nullptr) - 2 * here + function.value(at(i, -step), nullptr)) / (step * step);
    for (Eigen::Index j = 0; j < i; ++j)
      H(i, j) = H(j, i) =
          (function.value(at(i, step, j, step), nullptr) - function.value(at(i, step, j, -step), nullptr) -
           function.value(at(i, -step, j, step), nullptr) + function.value(at(i, -step, j, -step), nullptr)) /
          (4 * step * step);
  }
  return H;
}

std::vector<OpenDirection> open_directions(const Eigen::MatrixXd& curvature, double limit) {
  std::vector<OpenDirection> open;
  const algebra::Spectrum spectrum = algebra::spectrum(curvature);
  for (Eigen::Index k = 0; k < curvature.rows(); ++k) {
    const double value = spectrum.values[k];
    if (value * limit * limit >= 1) continue;
    OpenDirection direction;
    direction.direction = spectrum.vectors.col(k);
    direction.sigma = value > 0 ? 1 / std::sqrt(value) : std::numeric_limits<double>::infinity();
    const double largest = direction.direction.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < curvature.rows(); ++i)
      if (std::abs(direction.direction[i]) > 0.5 * largest) direction.involved.push_back(static_cast<std::size_t>(i));
    open.push_back(std::move(direction));
  }
  return open;
}

}  // namespace binnacle::tune
