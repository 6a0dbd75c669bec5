// SPDX-License-Identifier: Apache-2.0
// A velocity over ground in north-east-down axes.
#pragma once

#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle::navigation {

/// Stored, error and outputs: north, east, down [m/s]; ⊞ and ⊟ are + and −.
class VelocityBlock final : public StateBlock {
 public:
  static ComponentSpec spec();
  explicit VelocityBlock(const Binding& binding);

  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override;
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override;
  void read(ConstVectorView x, VectorView outputs) const override;
  Result write(ConstVectorView outputs, VectorView x) const override;

 private:
  StateBlockDeclaration declaration_;
};

}  // namespace binnacle::navigation
