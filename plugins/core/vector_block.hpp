// SPDX-License-Identifier: Apache-2.0
// A vector of like quantities as a state block: biases, scale factors, lever arms, misalignments.
#pragma once

#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle::core {

/// Kind "vector:N:UNIT". Stored value, error and outputs are the same N numbers [UNIT, SI]; ⊞ and ⊟ are + and −.
class VectorBlock final : public StateBlock {
 public:
  static ComponentSpec spec();
  explicit VectorBlock(const Binding& binding);

  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override;
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override;
  void read(ConstVectorView x, VectorView outputs) const override;
  Result write(ConstVectorView outputs, VectorView x) const override;

 private:
  StateBlockDeclaration declaration_;
};

}  // namespace binnacle::core
