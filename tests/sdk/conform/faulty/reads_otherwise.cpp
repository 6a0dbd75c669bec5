// SPDX-License-Identifier: Apache-2.0
// What it reads it does not write back.
// fails: numbers.block.readable
#include "faulty.hpp"

using namespace binnacle;

namespace {

class Subject final : public faulty::Block {
 public:
  using Block::Block;
  void read(ConstVectorView x, VectorView outputs) const override {
    Block::read(x, outputs);
    outputs[2] += 0.01;
  }
};

}  // namespace

BINNACLE_PLUGIN("reads_otherwise", "1.0.0", registry) { registry.add<Subject>(); }
