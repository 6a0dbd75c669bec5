// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a noise estimator, a running average of what the residuals say of R.
#include <binnacle/plugin.hpp>

#include <algorithm>
#include <cmath>

using namespace binnacle;

/// E[r rᵀ] = H P⁻ Hᵀ + R, so each residual shows Rᵢᵢ ≈ rᵢ² − (H P⁻ Hᵀ)ᵢᵢ. Its factor on the nominal Rᵢᵢ is averaged,
/// evenly over the first `memory` samples and then exponentially, and held between `floor` and `ceiling`; correlations
/// stay as they are.
class AveragedNoise final : public NoiseEstimator {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@";
    spec.summary = "R from an exponential average of squared residuals.";
    spec.source = "Mehra, On the identification of variances and adaptive Kalman filtering, IEEE TAC 15(2), 1970";
    spec.parameters = {
        parameter::number("memory", "1").at_least(1).defaults("50").about("samples that the average is over"),
        parameter::number("floor", "1").above(0).defaults("0.01").about("smallest factor on the nominal variance"),
        parameter::number("ceiling", "1").above(0).defaults("100").about("largest factor on the nominal variance")};
    spec.example = R"json({"memory": 20})json";
    return spec;
  }

  AveragedNoise(const Binding& b, const NoiseBinding& noise)
      : memory_(b.parameters().number("memory")),
        floor_(b.parameters().number("floor")),
        ceiling_(b.parameters().number("ceiling")) {
    if (ceiling_ < floor_) throw ComponentError("the ceiling is below the floor", "/ceiling");
    rows_ = declaration_.keeps_array<Row>(static_cast<std::size_t>(noise.max_rows));
  }

  void estimate(const Innovation& in, MatrixView R) const override {
    for (int i = 0; i < in.rows; ++i) {
      const double nominal = in.R_nominal(i, i);
      const double r = in.residual[i];
      const double observed = (r * r - in.HPHt(i, i)) / nominal;
      if (!(nominal > 0) || !std::isfinite(observed)) continue;
      Row& row = in.memory[rows_][static_cast<std::size_t>(i)];
      row.samples = std::min(row.samples + 1, memory_);
      row.factor += (observed - row.factor) / row.samples;
      scale(R, i, in.rows, std::clamp(row.factor, floor_, ceiling_));
    }
  }

 private:
  /// What is remembered of a row. It begins with the nominal variance as if that were one sample.
  struct Row {
    double samples = 1;  // in the average, at most `memory`
    double factor = 1;   // their average, neither floored nor capped
  };

  /// Rᵢᵢ times `factor`, with the same correlations as before.
  static void scale(MatrixView R, int i, int rows, double factor) {
    for (int j = 0; j < rows; ++j) {
      R(i, j) *= std::sqrt(factor);
      R(j, i) *= std::sqrt(factor);
    }
  }

  MemoryArray<Row> rows_;
  double memory_;  // samples
  double floor_, ceiling_;
};

BINNACLE_TYPES("@NAME@");
BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<AveragedNoise>(); }
