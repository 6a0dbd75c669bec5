// SPDX-License-Identifier: Apache-2.0
// DerivedBlock: a function of blocks that models bind to as if it were a block (an antenna, another frame).
#pragma once

#include <string>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

struct DerivedDeclaration {
  std::string kind;  // of what it yields: "position"
  int stored_size = 0;
  std::vector<NamedUnit> error;  // error components, those of the kind
  std::vector<int> read_ports;        // ports with a Jacobian block, by index in the spec's order; only bound ones

  int dof() const noexcept { return static_cast<int>(error.size()); }
};

/// y = g(x, u) with J = ∂(g(x ⊞ δ) ⊟ g(x))/∂δ per port, ⊟ being that of the kind it yields. The kernel multiplies the
/// Jacobians through to the state blocks. Immutable; never throws, never allocates.
class DerivedBlock {
 public:
  virtual ~DerivedBlock() = default;

  virtual const DerivedDeclaration& declaration() const noexcept = 0;
  /// value: stored_size. J: per entry of `read_ports`, dof × dof(port), zeroed by the kernel; null when no Jacobian is
  /// wanted, and then the value must be the same to the bit.
  virtual Result evaluate(const double* const* x, const Context& context, double* value, const MatrixView* J) const = 0;
};

}  // namespace binnacle
