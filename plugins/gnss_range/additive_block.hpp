// SPDX-License-Identifier: Apache-2.0
// A block whose value, error and outputs are the same numbers.
#pragma once

#include <algorithm>
#include <cmath>

#include "binnacle/state_block.hpp"

namespace binnacle::gnss_range {

template <int Size>
class AdditiveBlock : public StateBlock {
 public:
  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void plus(const double* x, const double* delta, double* result) const override {
    for (int i = 0; i < Size; ++i) result[i] = x[i] + delta[i];
  }
  void minus(const double* y, const double* x, double* delta) const override {
    for (int i = 0; i < Size; ++i) delta[i] = y[i] - x[i];
  }
  void read(const double* x, double* outputs) const override { std::copy_n(x, Size, outputs); }
  Result write(const double* outputs, double* x) const override {
    for (int i = 0; i < Size; ++i)
      if (!std::isfinite(outputs[i])) return Result::invalid("a value is not finite");
    std::copy_n(outputs, Size, x);
    return Result::ok();
  }

 protected:
  StateBlockDeclaration declaration_;
};

}  // namespace binnacle::gnss_range
