// SPDX-License-Identifier: Apache-2.0
// Its reset Jacobian has the wrong sign.
// fails: numbers.block.reset
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Block {
 public:
  using Block::Block;
  bool reset_jacobian(const double* d, double* G) const override {
    const double opposite[3] = {-d[0], -d[1], -d[2]};
    return Block::reset_jacobian(opposite, G);
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_reset", "1.0.0", registry) { registry.add<Subject>(); }
