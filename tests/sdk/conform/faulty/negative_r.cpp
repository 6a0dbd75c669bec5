// SPDX-License-Identifier: Apache-2.0
// Its R goes below zero after quiet stretches.
// fails: numbers.noise.covariance
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Noise {
 public:
  using Noise::Noise;
  void estimate(const binnacle::Innovation& in, binnacle::MatrixView R) const override {
    Noise::estimate(in, R);
    R(0, 0) -= 0.9 * in.R_nominal(0, 0);
  }
};

}  // namespace

BINNACLE_PLUGIN("negative_r", "1.0.0", registry) { registry.add<Subject>(); }
