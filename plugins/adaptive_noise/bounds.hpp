// SPDX-License-Identifier: Apache-2.0
// What keeps an estimate of R within reason, and turns variances of rows into R.
#pragma once

#include <string>
#include <vector>

#include "binnacle/noise_estimator.hpp"
#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::adaptive_noise {

/// Least and greatest standard deviation, as factors on the nominal one.
struct Bounds {
  double floor, ceiling;

  double clamped(double variance, double nominal) const noexcept {
    const double least = floor * floor * nominal, most = ceiling * ceiling * nominal;
    return variance > least ? (variance < most ? variance : most) : least;  // NaN: the least
  }
};

std::vector<ParameterSpec> bounds_parameters(std::string floor);
Bounds read_bounds(const Parameters& parameters);
/// Above which HP⁻Hᵀ, as a factor on the nominal R, a row teaches nothing.
ParameterSpec learn_below_parameter();

/// R with these variances on the diagonal and the correlations of the nominal R, which it holds on entry: D R D, positive
/// semidefinite as R is.
void set_variances(const double* variances, MatrixView R) noexcept;

}  // namespace binnacle::adaptive_noise
