// SPDX-License-Identifier: Apache-2.0
// R as a mean of innovations that forgets (Sage and Husa).
#pragma once

#include "binnacle/noise_estimator.hpp"
#include "binnacle/spec.hpp"
#include "bounds.hpp"
#include "row_memory.hpp"

namespace binnacle::adaptive_noise {

/// Per row
///     R ← (1 − d) R + d (r² − H P⁻ Hᵀ)     from "innovation"
///     R ← (1 − d) R + d (ε² + H P⁺ Hᵀ)     from "residual", ε after the update: never negative
/// with d = (1 − b)/(1 − b^(k+1)), k = 1, 2, …, the nominal R standing for the sample k = 0. What is remembered is not
/// bounded, only what is handed out: bounding the memory would make the mean of a noisy number too large.
class SageHusa final : public NoiseEstimator {
 public:
  static ComponentSpec spec();
  SageHusa(const Binding& binding, const NoiseBinding& noise);

  void estimate(const Innovation& in, MatrixView R) const override;
  void after(const AfterUpdate& in) const override;

 private:
  struct Row;  // what is remembered of one
  Row& row_at(const MemoryView& memory, int row) const noexcept;
  void learn(Row& row, double variance) const noexcept;

  RowMemory rows_;
  double forgetting_, learn_below_;
  Bounds bounds_;
  bool is_residual_;
  MemoryArray<double> variances_;
};

}  // namespace binnacle::adaptive_noise
