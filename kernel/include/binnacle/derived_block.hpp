// SPDX-License-Identifier: Apache-2.0
// DerivedBlock: a function of blocks that models bind to as if it were a block (an antenna, another frame).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/declaration.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/model_input.hpp"
#include "binnacle/result.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// What a bound derived block yields and reads:
///
///     declaration_.yields_like(binding.block("position")).reads(position_).reads(attitude_).reads(lever_arm_);
struct DerivedDeclaration : PortReader<DerivedDeclaration> {
  std::string kind;  // of what it yields: "position"
  int stored_size = 0;
  std::vector<NamedUnit> error;  // error components, those of the kind

  int dof() const noexcept { return static_cast<int>(error.size()); }

  DerivedDeclaration& yields(std::string what, int stored, std::vector<NamedUnit> components) {
    kind = std::move(what);
    stored_size = stored;
    error = std::move(components);
    return *this;
  }
  /// A value of the same kind as this block.
  DerivedDeclaration& yields_like(const PortBinding& block) {
    return yields(block.kind, block.stored_size, block.components);
  }
};

/// What evaluate() is given: stored values of the ports, and the driving rates.
struct DerivedInput {
  PortValues x;
  Driving u;
  Notes notes = {};
};

/// Where evaluate() writes.
struct DerivedOutput {
  VectorView value;  // stored_size
  PortJacobians J;  // of a port that is read: dof × dof(port), zeroed by the kernel; null when only the value is wanted
};

/// y = g(x, u) with J = ∂(g(x ⊞ δ) ⊟ g(x))/∂δ per port, ⊟ being that of the kind it yields. The kernel multiplies the
/// Jacobians through to the state blocks.
class DerivedBlock : public Declared<DerivedDeclaration> {
 public:
  /// The value, and J where it is wanted; without it the value is the same to the bit.
  virtual Result evaluate(const DerivedInput& in, DerivedOutput& out) const = 0;
};

}  // namespace binnacle
