// SPDX-License-Identifier: Apache-2.0
// How rare a NIS, or a mean of several, is.
#pragma once

#include <cmath>

namespace binnacle::score {

/// Normal score of a probability of 1e-6.
inline constexpr double rare_score = 4.75;

/// Of a χ² variable with d degrees of freedom, divided by d: its normal score (Wilson and Hilferty, 1931).
inline double chi_squared_score(double ratio, double d) {
  const double variance = 2 / (9 * d);
  return (std::cbrt(ratio) - 1 + variance) / std::sqrt(variance);
}

}  // namespace binnacle::score
