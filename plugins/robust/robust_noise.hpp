// SPDX-License-Identifier: Apache-2.0
// Noise estimators that give an outlier less weight: huber, cauchy, student_t, dcs.
#pragma once

#include "binnacle/noise_estimator.hpp"
#include "binnacle/spec.hpp"
#include "weights.hpp"

namespace binnacle::robust {

/// R/w by block of rows, w the fixed point of a loss's weights; what has passed the gate by the nominal R is weighed.
class RobustNoise : public NoiseEstimator {
 public:
  void estimate(const Innovation& in, MatrixView R) const override;

 protected:
  /// constant: the parameter with the loss's own constant, in place of the efficiency.
  RobustNoise(Loss loss, const char* constant, const Binding& binding, const NoiseBinding& noise);

 private:
  Method method_;
  MemoryArray<Row> rows_;  // scratch
};

struct Huber final : RobustNoise {
  static ComponentSpec spec();
  Huber(const Binding& binding, const NoiseBinding& noise);
};
struct Cauchy final : RobustNoise {
  static ComponentSpec spec();
  Cauchy(const Binding& binding, const NoiseBinding& noise);
};
struct StudentT final : RobustNoise {
  static ComponentSpec spec();
  StudentT(const Binding& binding, const NoiseBinding& noise);
};
struct DynamicCovarianceScaling final : RobustNoise {
  static ComponentSpec spec();
  DynamicCovarianceScaling(const Binding& binding, const NoiseBinding& noise);
};

}  // namespace binnacle::robust
