// SPDX-License-Identifier: Apache-2.0
// Takes the whole innovation for measurement noise.
// fails: numbers.noise.recovery
#include "faulty.hpp"

namespace faulty::forgets_hph {

class Subject final : public Noise {
 public:
  using Noise::Noise;
  void estimate(const Innovation& in, MatrixView R) const override {
    Noise::estimate(in, R);
    for (int i = 0; i < in.rows; ++i) R(i, i) += 3 * in.HPHt(i, i);
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("forgets_hph")); }

}  // namespace faulty::forgets_hph
