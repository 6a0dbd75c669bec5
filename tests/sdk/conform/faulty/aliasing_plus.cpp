// SPDX-License-Identifier: Apache-2.0
// Its plus goes wrong when x and result are the same memory.
// fails: numbers.block.laws
#include "faulty.hpp"

using namespace binnacle;

namespace {

class Subject final : public faulty::Block {
 public:
  using Block::Block;
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    result[0] = 0;
    const Eigen::Vector4d q(x[0] == 0 ? 0.7 : x[0], x[1], x[2], x[3]);
    Block::plus(q, delta, result);
  }
};

}  // namespace

BINNACLE_PLUGIN("aliasing_plus", "1.0.0", registry) { registry.add<Subject>(); }
