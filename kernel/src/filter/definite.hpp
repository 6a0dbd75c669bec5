// SPDX-License-Identifier: Apache-2.0
// Whether P is a covariance: no variance of a combination of components is negative.
#pragma once

#include "binnacle/view.hpp"

namespace binnacle::internal::filter {

/// Of a component's variance, what is left once all before it are known; negative: P is no covariance.
struct VarianceLeft {
  int row = -1;      // of P; −1: nothing is wrong with it
  double share = 0;  // of its own variance: 1 − ρ² of two
};

/// What rounding leaves below zero where P₀/R is 1e10 or so.
inline constexpr double definite_within = 1e-6;

/// An update that sees so many times the variance of its noise leaves less than a tenth of the digits of that noise in a P
/// that is kept expanded.
inline constexpr double unresolved_from = 1e15;

/// The first row where less than −definite_within is left. `factor`: n × n doubles of scratch.
VarianceLeft indefinite_row(ConstMatrixView P, double* factor);

}  // namespace binnacle::internal::filter
