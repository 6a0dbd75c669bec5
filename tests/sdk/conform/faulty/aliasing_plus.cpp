// SPDX-License-Identifier: Apache-2.0
// Its plus goes wrong when x and result are the same memory.
// fails: numbers.block.laws
#include "faulty.hpp"

namespace faulty::aliasing_plus {

class Subject final : public Block {
 public:
  using Block::Block;
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    result[0] = 0;
    const Eigen::Vector4d q(x[0] == 0 ? 0.7 : x[0], x[1], x[2], x[3]);
    Block::plus(q, delta, result);
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("aliasing_plus")); }

}  // namespace faulty::aliasing_plus
