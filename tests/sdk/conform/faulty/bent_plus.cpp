// SPDX-License-Identifier: Apache-2.0
// Its minus takes the half of what plus gave.
// fails: numbers.block.laws
#include "faulty.hpp"

using namespace binnacle;

namespace {

class Subject final : public faulty::Block {
 public:
  using Block::Block;
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    Block::minus(y, x, delta);
    for (int i = 0; i < 3; ++i) delta[i] *= 0.5;
  }
};

}  // namespace

BINNACLE_PLUGIN("bent_plus", "1.0.0", registry) { registry.add<Subject>(); }
