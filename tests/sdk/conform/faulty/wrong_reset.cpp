// SPDX-License-Identifier: Apache-2.0
// Its reset Jacobian has the wrong sign.
// fails: numbers.block.reset
#include "faulty.hpp"

namespace faulty::wrong_reset {

class Subject final : public Block {
 public:
  using Block::Block;
  bool reset_jacobian(ConstVectorView x, ConstVectorView d, MatrixView G) const override {
    const Eigen::Vector3d opposite = -d.as<3>();
    return Block::reset_jacobian(x, opposite, G);
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("wrong_reset")); }

}  // namespace faulty::wrong_reset
