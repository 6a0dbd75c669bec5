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
  void plus(const double* x, const double* delta, double* result) const override;
  void minus(const double* y, const double* x, double* delta) const override;
  void read(const double* x, double* outputs) const override;
  Result write(const double* outputs, double* x) const override;

 private:
  StateBlockDeclaration declaration_;
};

}  // namespace binnacle::navigation
