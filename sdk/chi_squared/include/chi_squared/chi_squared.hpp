// SPDX-License-Identifier: Apache-2.0
// The chi-squared distribution.
#pragma once

#include <utility>

namespace binnacle {

/// The x that a chi-squared variable of `dof` degrees of freedom, above 0, stays below with probability p.
double chi_squared_quantile(double dof, double p);

/// [low, high] that the mean of n independent chi-squared variables of `dof` degrees of freedom lies in with a probability;
/// the rest is split evenly. All above 0.
std::pair<double, double> chi_squared_band(double dof, double n, double probability);

}  // namespace binnacle
