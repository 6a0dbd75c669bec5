// SPDX-License-Identifier: Apache-2.0
// Its Jacobian of the outputs is that of an error from the other side.
// fails: numbers.block.outputs
#include "faulty.hpp"

namespace faulty::wrong_outputs {

class Subject final : public Block {
 public:
  using Block::Block;
  bool output_jacobian(ConstVectorView x, MatrixView J) const override {
    // log(q exp(d)) = log(q) + J_r⁻¹ d, where exp(d) q is meant; to second order they differ by the sign of half a turn.
    Eigen::Vector3d v;
    read(x, v);
    J.as<3, 3>() << 1, -v[2] / 2, v[1] / 2, v[2] / 2, 1, -v[0] / 2, -v[1] / 2, v[0] / 2, 1;
    return true;
  }
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("wrong_outputs")); }

}  // namespace faulty::wrong_outputs
