// SPDX-License-Identifier: Apache-2.0
// The weights of one sample: its blocks of rows, and the fixed point of each loss's weights.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "binnacle/noise_estimator.hpp"
#include "loss.hpp"

namespace binnacle::robust {

/// Which rows share a weight.
enum class Unit { sample, part, key, row };

/// Scratch of one row.
struct Row {
  double weight;         // of its block
  double y, v;           // S⁻¹ r and R S⁻¹ r, or on the way to them
  double root;           // diagonal of the factor of its block of R
  std::int64_t member;   // the rows in order of their blocks; what follows is of this row
  std::int64_t count;    // rows of its block
  std::int64_t is_held;  // its block's weight is 1: there is no noise to weigh
};

/// How a sample's weights are found.
struct Method {
  Loss loss = Loss::huber;
  std::vector<double> tuning;  // by m − 1
  Unit unit = Unit::sample;
  Whitened of = Whitened::innovation;
  int iterations = 100;
  double tolerance = 1e-6;  // of ln w
};

/// What there is to say of it.
struct Findings {
  bool has_converged = true;
  bool is_at_least = false;  // a weight is `least_weight`
  bool is_held = false;      // a block has no noise
};

/// So that R/w is finite: an outlier of a million σ has no effect on anything.
inline constexpr double least_weight = 1e-12;

/// Writes R/w, off the diagonal of the blocks R_ij/√(w_i w_j), so R keeps its correlations and stays positive
/// semidefinite. R, which holds anything on entry, is the only matrix it works in; `rows` has as many as the sample.
Findings write_weighted(const Method& method, const Innovation& in, std::span<Row> rows, MatrixView R) noexcept;

}  // namespace binnacle::robust
