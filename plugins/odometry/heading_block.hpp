// SPDX-License-Identifier: Apache-2.0
// The heading of a vehicle on the ground.
#pragma once

#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle::odometry {

/// An angle about down, from true north, east positive; in (−π, π]. ⊞ adds and wraps.
class HeadingBlock final : public StateBlock {
 public:
  static ComponentSpec spec();
  explicit HeadingBlock(const Binding& binding);

  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override;
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override;
  void read(ConstVectorView x, VectorView outputs) const override;
  Result write(ConstVectorView outputs, VectorView x) const override;
  bool output_jacobian(ConstVectorView x, MatrixView J) const override;

 private:
  StateBlockDeclaration declaration_;
};

}  // namespace binnacle::odometry
