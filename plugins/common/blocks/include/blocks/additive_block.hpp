// SPDX-License-Identifier: Apache-2.0
// A block whose value, error and outputs are the same numbers.
#pragma once

#include <cmath>

#include "binnacle/state_block.hpp"

namespace binnacle::blocks {

/// ⊞ and ⊟ are + and −. Its constructor writes declaration_, with as many components, outputs and stored numbers.
class AdditiveBlock : public StateBlock {
 public:
  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    for (int i = 0; i < declaration_.stored_size; ++i) result[i] = x[i] + delta[i];
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    for (int i = 0; i < declaration_.stored_size; ++i) delta[i] = y[i] - x[i];
  }
  void read(ConstVectorView x, VectorView outputs) const override { outputs.as() = x.as(); }
  Result write(ConstVectorView outputs, VectorView x) const override {
    for (int i = 0; i < declaration_.stored_size; ++i)
      if (!std::isfinite(outputs[i])) return Result::invalid("a component is not finite");
    x.as() = outputs.as();
    return Result::ok();
  }

 protected:
  StateBlockDeclaration declaration_;
};

}  // namespace binnacle::blocks
