// SPDX-License-Identifier: Apache-2.0
// What the declarations of several models have in common, and what becomes of them.
#pragma once

#include <vector>

#include "binnacle/handle.hpp"
#include "binnacle/memory.hpp"

namespace binnacle {

/// Where a model's Jacobians come from; `binnacle explain` names the models that leave it to a machine.
enum class Differentiation { by_hand, dual_numbers, differences };

/// Part of each `Declaration` of a model that has Jacobians.
template <class Declaration>
struct Differentiable {
  Differentiation differentiation = Differentiation::by_hand;

  /// Where its Jacobians come from, when not from a pencil (jacobian.hpp).
  Declaration& differentiated_by(Differentiation how) {
    differentiation = how;
    return static_cast<Declaration&>(*this);
  }
};

/// Part of each that has them by port: H, J.
template <class Declaration>
struct PortReader : Differentiable<Declaration> {
  std::vector<int> read_ports;  // ports with a Jacobian block, by index in the spec's order; only bound ones

  /// H, or J, has a block with respect to this port. An open port is ignored.
  Declaration& reads(Port port) {
    if (port.is_bound()) read_ports.push_back(port.index());
    return static_cast<Declaration&>(*this);
  }
};

/// A model that says what it does, and may remember: its constructor takes its handles from the Binding and fills
/// `declaration_`. Immutable afterwards; never throws, never allocates, touches only what it is handed.
template <class Declaration>
class DeclaredModel {
 public:
  virtual ~DeclaredModel() = default;

  virtual const Declaration& declaration() const noexcept { return declaration_; }
  /// Memory at the start of a run.
  void start(MemoryView memory) const {
    declaration().write_initial(memory.data());
    initialise(memory);
  }

 protected:
  /// For memory whose first value depends on a parameter.
  virtual void initialise(const MemoryView& /*memory*/) const {}

  Declaration declaration_;
};

}  // namespace binnacle
