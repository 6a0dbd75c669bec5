// SPDX-License-Identifier: Apache-2.0
// R = R1 + β R2, with β fitted to the residuals of a window (paper 000).
#pragma once

#include <optional>
#include <vector>

#include "binnacle/noise_estimator.hpp"
#include "binnacle/spec.hpp"
#include "bounds.hpp"
#include "row_memory.hpp"

namespace binnacle::adaptive_noise {

/// Paper 000, (9)–(30). With M the mean of ε εᵀ over the last N samples, this one included (15), and L1 = H P⁻ Hᵀ + R1,
///     β = tr[(M − L1) R2ᵀ] / tr[R2 R2ᵀ]                                                      (19)
/// minimizes ‖M − (L1 + β R2)‖. The division is lost in (20) and (26); without it β is too large by the number of rows.
/// Only diagonals enter, R1 and R2 being diagonal; off the diagonal R keeps the correlations of the nominal one.
class BetaAdapter final : public NoiseEstimator {
 public:
  static ComponentSpec spec();
  BetaAdapter(const Binding& binding, const NoiseBinding& noise);

  void estimate(const Innovation& in, MatrixView R) const override;

 private:
  enum class Per { group, component, one };
  struct Unit;  // what shares one β

  using Variances = std::vector<std::optional<double>>;  // per group; none: from the nominal R

  static Variances read_variances(const Parameters& parameters, const char* name, const NoiseBinding& noise);
  int unit_count() const noexcept;
  int unit_of(const MemoryView& memory, int row) const noexcept;

  Window window_;
  RowMemory rows_;
  Per per_;
  Variances r1_, r2_;
  double r1_factor_;
  Bounds bounds_;
  bool waits_, holds_;
  MemoryArray<Unit> units_;
  MemoryArray<double> variances_;
};

}  // namespace binnacle::adaptive_noise
