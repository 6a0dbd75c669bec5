// SPDX-License-Identifier: Apache-2.0
// Weights of increments over intervals of any lengths, from rates that are polynomials in time.
#pragma once

#include <span>

#include "attitude/rotation_vector.hpp"

namespace binnacle::attitude {

/// Of N increments over intervals h_i, h = Σ h_i, where α(t) = Σ β_i(t) θ_i is the polynomial of degree N through what has
/// been turned at the ends of the intervals (and v(t) likewise what has been gained):
///   pairs     k_ij = ½ ∫ (β_i β_j′ − β_j β_i′) dt            ½ ∫ α × ω dt = Σ_{i<j} k_ij θ_i × θ_j
///   position  s_i = ∫ β_i dt / h                            ∫ v dt = h Σ s_i Δv_i
///   turned    m_ij = ∫ (1 − t/h) β_i β_j′ dt                 ∫ (h − t) α × f dt = h Σ m_ij θ_i × Δv_j
/// For equal intervals the pairs are those of Form::polynomial.
struct IntervalWeights {
  PairWeights<double> pairs;
  double position[most_samples] = {};
  double turned[most_samples][most_samples] = {};
};

/// One to four lengths, all positive.
IntervalWeights interval_weights(std::span<const double> lengths);

/// To one part in 1e5: labels that were rounded to a nanosecond are no other intervals.
bool are_equal(std::span<const double> lengths);

}  // namespace binnacle::attitude
