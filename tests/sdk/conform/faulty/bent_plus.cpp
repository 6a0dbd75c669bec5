// SPDX-License-Identifier: Apache-2.0
// Its minus takes the half of what plus gave.
// fails: numbers.block.laws
#include "faulty.hpp"

namespace faulty::bent_plus {

class Subject final : public Block {
 public:
  using Block::Block;
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    Block::minus(y, x, delta);
    for (int i = 0; i < 3; ++i) delta[i] *= 0.5;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("bent_plus")); }

}  // namespace faulty::bent_plus
