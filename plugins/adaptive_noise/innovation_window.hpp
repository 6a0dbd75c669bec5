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

  std::size_t memory_bytes() const noexcept override;
  void start(std::byte* memory) const override;
  void estimate(const Innovation& innovation, std::byte* memory, MatrixView R) const override;
  bool wants_after() const noexcept override { return is_residual_; }
  void after(Outcome outcome, const double* post_fit_residual, MatrixView HPHt_plus, std::byte* memory) const override;

 private:
  struct Scratch {
    double* estimate;  // m×m
    double* root;      // m×m
    double* vectors;   // m×m
    double* update;    // m×m, H P⁺ Hᵀ of the last update by slots: memory, not scratch
    double* learnt;    // m, whether a row of the sample at hand is to be learnt from: memory
  };
  Scratch scratch(std::byte* memory) const noexcept;
  void write_diagonal(const Innovation& innovation, std::byte* memory, MatrixView R) const noexcept;
  void write_full(const Innovation& innovation, std::byte* memory, MatrixView R) const noexcept;
  /// C ∓ HPHᵀ of two rows.
  double covariance(const Innovation& innovation, std::byte* memory, int i, int j) const noexcept;

  Window window_;
  RowMemory rows_;
  double learn_below_;
  Bounds bounds_;
  bool is_residual_, is_full_;
};

}  // namespace binnacle::adaptive_noise
