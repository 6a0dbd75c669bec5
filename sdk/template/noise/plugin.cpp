// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a noise estimator, a running average of what the residuals say of R.
#include <binnacle/plugin.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>

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
      : rows_(noise.max_rows),
        memory_(b.parameters().number("memory")),
        floor_(b.parameters().number("floor")),
        ceiling_(b.parameters().number("ceiling")) {
    if (ceiling_ < floor_) throw ComponentError("the ceiling is below the floor", "/ceiling");
  }

  std::size_t memory_bytes() const noexcept override { return static_cast<std::size_t>(rows_) * sizeof(Row); }

  void start(std::byte* memory) const override {
    const Row nominal{1, 1};
    for (int i = 0; i < rows_; ++i) std::memcpy(at(memory, i), &nominal, sizeof nominal);
  }

  void estimate(const Innovation& innovation, std::byte* memory, MatrixView R) const override {
    for (int i = 0; i < innovation.rows; ++i) {
      const double nominal = innovation.R_nominal(i, i);
      const double r = innovation.residual[i];
      const double observed = (r * r - innovation.HPHt(i, i)) / nominal;
      if (!(nominal > 0) || !std::isfinite(observed)) continue;
      Row row;
      std::memcpy(&row, at(memory, i), sizeof row);
      row.samples = std::min(row.samples + 1, memory_);
      row.factor += (observed - row.factor) / row.samples;
      std::memcpy(at(memory, i), &row, sizeof row);
      scale(R, i, innovation.rows, std::clamp(row.factor, floor_, ceiling_));
    }
  }

 private:
  /// What is remembered of a row. It begins with the nominal variance as if that were one sample.
  struct Row {
    double samples;  // in the average, at most `memory`
    double factor;   // their average, neither floored nor capped
  };
  static std::byte* at(std::byte* memory, int row) { return memory + static_cast<std::size_t>(row) * sizeof(Row); }

  /// Rᵢᵢ times `factor`, with the same correlations as before.
  static void scale(MatrixView R, int i, int rows, double factor) {
    for (int j = 0; j < rows; ++j) {
      R(i, j) *= std::sqrt(factor);
      R(j, i) *= std::sqrt(factor);
    }
  }

  int rows_;
  double memory_;  // samples
  double floor_, ceiling_;
};

BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<AveragedNoise>(); }
