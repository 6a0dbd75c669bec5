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
  RobustNoise(Loss loss, const Binding& binding, const NoiseBinding& noise);

 private:
  Method method_;
  MemoryArray<Row> rows_;  // scratch
};

template <Loss loss>
struct NoiseOf final : RobustNoise {
  static ComponentSpec spec();
  NoiseOf(const Binding& binding, const NoiseBinding& noise) : RobustNoise(loss, binding, noise) {}
};
using Huber = NoiseOf<Loss::huber>;
using Cauchy = NoiseOf<Loss::cauchy>;
using StudentT = NoiseOf<Loss::student_t>;
using DynamicCovarianceScaling = NoiseOf<Loss::dcs>;
template <>
ComponentSpec Huber::spec();
template <>
ComponentSpec Cauchy::spec();
template <>
ComponentSpec StudentT::spec();
template <>
ComponentSpec DynamicCovarianceScaling::spec();

}  // namespace binnacle::robust
