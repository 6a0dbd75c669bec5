// SPDX-License-Identifier: Apache-2.0
// Directions of a state that the measurements do not see, and the components that they are made of.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace binnacle::observe {

/// Known: the samples remove at least this share of the variance. At one half they say as much as what was known before.
constexpr double known_share = 0.5;

/// A component in a direction.
struct Part {
  int row = 0;              // of P
  double displacement = 0;  // of one standard deviation along the direction [SI]
  double share = 0;         // of the variance that is left of the component, what lies along the direction
  double of_before = 0;     // of the variance that the component had before, what lies along the direction
};

/// What is left after the samples is a sum of independent errors along directions.
struct Direction {
  /// By row. Components with more than half of what is left of them along it: the two that most is left of, by the
  /// variance before, and all that no less than a hundredth of the first's is left of. One at least.
  std::vector<Part> parts;
  Eigen::VectorXd along;  // unit vector in the columns of W
};

/// The directions that D does not know: eigenvectors of D below known_share, turned among themselves (varimax; Kaiser,
/// Psychometrika 23, 1958) until each is of as few components as can be. W: n×r, W Wᵀ = P before; D: r×r, the share
/// of it removed (information.hpp). In the order of their first rows.
std::vector<Direction> weak_directions(const Eigen::MatrixXd& W, const Eigen::MatrixXd& D);

/// A direction along which a filter has removed variance that the measurements do not remove.
struct SpuriousDirection : Direction {
  double claimed = 0;  // share that the filter's own linearization removes
  double removed = 0;  // share that is removed where all is linearized along one path
};

/// Of the directions unknown to `on_path`, those along which `claimed` leaves less than known_share of what `on_path` leaves.
/// Both D of the same W.
std::vector<SpuriousDirection> spurious_directions(const Eigen::MatrixXd& W, const Eigen::MatrixXd& claimed,
                                                   const Eigen::MatrixXd& on_path);

/// Variances of the rows of P that are left: the diagonal of W (I − D) Wᵀ.
Eigen::VectorXd variances_left(const Eigen::MatrixXd& W, const Eigen::MatrixXd& D);

/// Roots of the eigenvalues of Wᵀ Y W, Y the information of the samples: before over after is √(1 + s²). Descending. No larger
/// than what rounding lets D resolve.
std::vector<double> singular_values(const Eigen::MatrixXd& D);

}  // namespace binnacle::observe
