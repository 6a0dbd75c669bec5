// SPDX-License-Identifier: Apache-2.0
// Its reset Jacobian has the wrong sign.
// fails: numbers.block.reset
#include "faulty.hpp"

using namespace binnacle;

namespace {

class Subject final : public faulty::Block {
 public:
  using Block::Block;
  bool reset_jacobian(ConstVectorView x, ConstVectorView d, MatrixView G) const override {
    const Eigen::Vector3d opposite = -d.as<3>();
    return Block::reset_jacobian(x, opposite, G);
  }
};

}  // namespace

BINNACLE_PLUGIN("wrong_reset", "1.0.0", registry) { registry.add<Subject>(); }
