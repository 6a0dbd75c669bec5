// SPDX-License-Identifier: Apache-2.0
// Plain state blocks of the standard kinds, for tests of models that bind to such kinds. Needs Eigen and nothing else.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/state_block.hpp"
#include "binnacle/view.hpp"

namespace binnacle::testing {

/// Written from the definition of the kinds alone, not with the functions that the plugins use.
class KindBlock : public StateBlock {
 public:
  const StateBlockDeclaration& declaration() const noexcept override { return declaration_; }
  void read(ConstVectorView x, VectorView outputs) const override {
    std::copy_n(x.data(), outputs.size(), outputs.data());
  }
  Result write(ConstVectorView /*outputs*/, VectorView /*x*/) const override {
    return Result::invalid("the blocks of tests are not written");
  }

 protected:
  KindBlock(std::string kind, int stored_size, std::vector<NamedUnit> error) {
    declaration_.kind = std::move(kind);
    declaration_.stored_size = stored_size;
    declaration_.error = std::move(error);
  }

 private:
  StateBlockDeclaration declaration_;
};

/// "vector:N:UNIT", and with another kind any additive block.
class AdditiveKind final : public KindBlock {
 public:
  AdditiveKind(int size, const std::string& unit)
      : AdditiveKind("vector:" + std::to_string(size) + ":" + unit, size, unit) {}
  AdditiveKind(std::string kind, int size, const std::string& unit)
      : KindBlock(std::move(kind), size, names(size, unit)) {}

  void plus(ConstVectorView x, ConstVectorView delta, VectorView result) const override {
    for (int i = 0; i < declaration().stored_size; ++i) result[i] = x[i] + delta[i];
  }
  void minus(ConstVectorView y, ConstVectorView x, VectorView delta) const override {
    for (int i = 0; i < declaration().stored_size; ++i) delta[i] = y[i] - x[i];
  }

 private:
  static std::vector<NamedUnit> names(int size, const std::string& unit) {
    std::vector<NamedUnit> components;
    for (int i = 0; i < size; ++i) components.push_back({std::string("e").append(std::to_string(i)), unit});
    return components;
  }
};

}  // namespace binnacle::testing
