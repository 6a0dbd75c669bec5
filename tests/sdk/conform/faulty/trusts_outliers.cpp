// SPDX-License-Identifier: Apache-2.0
// A robust loss that multiplies R by its weight instead of dividing by it.
// fails: numbers.noise.outlier
#include "faulty.hpp"

#include <cmath>

namespace faulty::trusts_outliers {

class Subject final : public Noise {
 public:
  Subject(const Binding& binding, const NoiseBinding& noise) : Noise(binding, noise) {
    declaration_.judged_by_nominal();
  }
  void estimate(const Innovation& in, MatrixView R) const override {
    for (int i = 0; i < in.rows; ++i) {
      const double d2 = in.residual[i] * in.residual[i] / (in.HPHt(i, i) + in.R_nominal(i, i));
      if (std::isfinite(d2)) R(i, i) = in.R_nominal(i, i) * (0.01 + 1 / (1 + d2));
    }
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("trusts_outliers")); }

}  // namespace faulty::trusts_outliers
