// SPDX-License-Identifier: Apache-2.0
// Takes the whole innovation for measurement noise.
// fails: numbers.noise.recovery
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Noise {
 public:
  using Noise::Noise;
  void estimate(const binnacle::Innovation& innovation, std::byte* memory, binnacle::MatrixView R) const override {
    Noise::estimate(innovation, memory, R);
    for (int i = 0; i < innovation.rows; ++i) R(i, i) += 3 * innovation.HPHt(i, i);
  }
};

}  // namespace

BINNACLE_PLUGIN("forgets_hph", "1.0.0", registry) { registry.add<Subject>(); }
