// SPDX-License-Identifier: Apache-2.0
// Whether a filter is as good as it thinks: shares within its own σ, and χ² bounds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace binnacle::report {

/// How many of the errors with a σ above zero lie within k σ.
struct Within {
  std::size_t one = 0, two = 0, three = 0;
  std::size_t of = 0;
};
Within within_sigma(std::span<const double> errors, std::span<const double> sigma);

/// What 95 % of χ² of so many degrees of freedom lie between; {0, 0} of none.
std::pair<double, double> chi_squared_95(double dof);

/// What 99 % of means of n independent χ² lie between.
std::pair<double, double> mean_chi_squared_99(double dof, double n);

/// Means over up to `count` values each, one after the other.
struct MovingMean {
  std::vector<double> t, mean;
  double low = 0, high = 0;  // 95 % of such means lie between if they are χ² of the dof
};
MovingMean moving_mean(std::span<const double> t, std::span<const double> values, double mean_dof);

}  // namespace binnacle::report
