// SPDX-License-Identifier: Apache-2.0
// R from the covariance of a window of innovations or residuals (Mohamed and Schwarz).
#pragma once

#include "binnacle/noise_estimator.hpp"
#include "binnacle/spec.hpp"
#include "bounds.hpp"
#include "row_memory.hpp"

namespace binnacle::adaptive_noise {

/// With C the mean of products over the last N samples,
///     R = C_r − H P⁻ Hᵀ     from "innovation", before the update
///     R = C_ε + H P⁺ Hᵀ     from "residual", after the update
/// The residual of a sample is known after its update: what "residual" hands out is from the N samples before. Nominal R
/// until there are N. "full" estimates correlations too; in coordinates in which the nominal R is the identity the
/// eigenvalues are bounded by floor² and ceiling², so R is positive definite for a floor above zero.
class InnovationWindow final : public NoiseEstimator {
 public:
  static ComponentSpec spec();
  InnovationWindow(const Binding& binding, const NoiseBinding& noise);

  void estimate(const Innovation& in, MatrixView R) const override;
  void after(const AfterUpdate& in) const override;

 private:
  void write_diagonal(const Innovation& in, MatrixView R) const noexcept;
  void write_full(const Innovation& in, MatrixView R) const noexcept;
  /// C ∓ HPHᵀ of two rows.
  double covariance(const Innovation& in, int i, int j) const noexcept;

  Window window_;
  RowMemory rows_;
  double learn_below_;
  Bounds bounds_;
  bool is_residual_, is_full_;
  MemoryArray<double> estimate_, root_, vectors_;  // m×m, scratch
  MemoryArray<double> update_;                     // m×m, H P⁺ Hᵀ of the last update by slots
  MemoryArray<double> learnt_;                     // m, whether a row of the sample at hand is to be learnt from
};

}  // namespace binnacle::adaptive_noise
