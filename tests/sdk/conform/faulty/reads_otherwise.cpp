// SPDX-License-Identifier: Apache-2.0
// What it reads it does not write back.
// fails: numbers.block.readable
#include "faulty.hpp"

namespace faulty::reads_otherwise {

class Subject final : public Block {
 public:
  using Block::Block;
  void read(ConstVectorView x, VectorView outputs) const override {
    Block::read(x, outputs);
    outputs[2] += 0.01;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("reads_otherwise")); }

}  // namespace faulty::reads_otherwise
