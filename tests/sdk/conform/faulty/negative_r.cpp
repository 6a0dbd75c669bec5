// SPDX-License-Identifier: Apache-2.0
// Its R goes below zero after quiet stretches.
// fails: numbers.noise.covariance
#include "faulty.hpp"

namespace faulty::negative_r {

class Subject final : public Noise {
 public:
  using Noise::Noise;
  void estimate(const Innovation& in, MatrixView R) const override {
    Noise::estimate(in, R);
    R(0, 0) -= 0.9 * in.R_nominal(0, 0);
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("negative_r")); }

}  // namespace faulty::negative_r
