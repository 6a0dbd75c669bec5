// SPDX-License-Identifier: Apache-2.0
// Takes the whole innovation for measurement noise.
// fails: numbers.noise.recovery
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Noise {
 public:
  using Noise::Noise;
  void estimate(const binnacle::Innovation& in, binnacle::MatrixView R) const override {
    Noise::estimate(in, R);
    for (int i = 0; i < in.rows; ++i) R(i, i) += 3 * in.HPHt(i, i);
  }
};

}  // namespace

BINNACLE_PLUGIN("forgets_hph", "1.0.0", registry) { registry.add<Subject>(); }
