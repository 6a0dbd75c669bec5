// SPDX-License-Identifier: Apache-2.0
// A block whose value, error and outputs are the same numbers.
#pragma once

#include <cmath>

#include "binnacle/state_block.hpp"

namespace binnacle::gnss_range {

template <int Size>
class AdditiveBlock : public StateBlock {
 public:
  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    for (int i = 0; i < Size; ++i) result[i] = x[i] + delta[i];
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    for (int i = 0; i < Size; ++i) delta[i] = y[i] - x[i];
  }
  void read(ConstVectorView x, VectorView outputs) const override { outputs.as<Size>() = x.as<Size>(); }
  Result write(ConstVectorView outputs, VectorView x) const override {
    for (int i = 0; i < Size; ++i)
      if (!std::isfinite(outputs[i])) return Result::invalid("a value is not finite");
    x.as<Size>() = outputs.as<Size>();
    return Result::ok();
  }

 protected:
  StateBlockDeclaration declaration_;
};

}  // namespace binnacle::gnss_range
