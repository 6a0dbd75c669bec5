// SPDX-License-Identifier: Apache-2.0
// What the declarations of several components have in common: memory, which the kernel keeps in the arena, and Jacobians.
#pragma once

#include <cstddef>
#include <cstring>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

#include "binnacle/handle.hpp"

namespace binnacle {

/// How much of a block of Φ, F or Q is ever non-zero; the kernel does no arithmetic on the rest.
/// `dense`: dof(to)×dof(from) elements. `diagonal`: the dof diagonal elements (both ports of equal dof).
enum class Structure { dense, diagonal };

/// The block of Φ with the rows of port `to` and the columns of port `from`. Ports by index in the spec's order.
struct Coupling {
  int to = 0;
  int from = 0;
  Structure structure = Structure::dense;
};

/// A component's memory during one call.
class MemoryView {
 public:
  constexpr MemoryView() = default;
  constexpr MemoryView(std::byte* data) noexcept : data_(data) {}

  constexpr std::byte* data() const noexcept { return data_; }
  template <class T>
  T& operator[](Memory<T> handle) const noexcept {
    return *std::launder(reinterpret_cast<T*>(data_ + handle.offset));
  }
  template <class T>
  std::span<T> operator[](MemoryArray<T> handle) const noexcept {
    return {reinterpret_cast<T*>(data_ + handle.offset), handle.count};
  }

 private:
  std::byte* data_ = nullptr;
};

/// The part of a declaration that says what the component remembers.
struct MemoryDeclaration {
  std::size_t memory_bytes = 0;
  std::vector<std::byte> initial_memory;  // what the first of them hold at the start of a run; the rest is zero

  /// One T, at the start of a run T{}. A snapshot is a copy of bytes, so T must be trivially copyable, and without
  /// members that want more than 8-byte alignment (plain doubles instead of Eigen vectors: view.hpp maps them).
  template <class T>
  Memory<T> keeps() {
    return {add<T>(1)};
  }
  /// `count` of them, each at first T{}.
  template <class T>
  MemoryArray<T> keeps_array(std::size_t count) {
    return {add<T>(count), count};
  }
  /// Memory as it is at the start of a run, before the component's own initialise().
  void write_initial(std::byte* memory) const {
    if (memory_bytes > 0) std::memset(memory, 0, memory_bytes);
    if (!initial_memory.empty()) std::memcpy(memory, initial_memory.data(), initial_memory.size());
  }

 private:
  template <class T>
  std::size_t add(std::size_t count) {
    static_assert(std::is_trivially_copyable_v<T>, "a snapshot is a copy of bytes");
    static_assert(alignof(T) <= 8, "kernel memory is 8-byte aligned and no more");
    const std::size_t offset = (memory_bytes + 7) / 8 * 8;
    memory_bytes = offset + count * sizeof(T);
    initial_memory.resize(memory_bytes);  // zeroed: no byte of padding is left to chance
    for (std::size_t i = 0; i < count; ++i) ::new (initial_memory.data() + offset + i * sizeof(T)) T();
    return offset;
  }
};

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

/// A component that says what it does: its constructor takes its handles from the Binding and fills `declaration_`.
/// Immutable afterwards; a model never throws, never allocates, touches only what it is handed.
template <class Declaration>
class Declared {
 public:
  virtual ~Declared() = default;
  virtual const Declaration& declaration() const noexcept { return declaration_; }

 protected:
  Declaration declaration_;
};

/// One that may remember, and whose memory may hold random state: `Seed` is std::uint64_t then, and nothing otherwise.
template <class Declaration, class... Seed>
class DeclaredModel : public Declared<Declaration> {
 public:
  /// Memory at the start of a run. The seed is unique to the run's seed, its number and this component; equal seeds give
  /// equal samples.
  void start(Seed... seed, MemoryView memory) const {
    this->declaration().write_initial(memory.data());
    initialise(seed..., memory);
  }

 protected:
  /// For memory whose first value depends on the seed or a parameter.
  virtual void initialise(Seed... /*seed*/, const MemoryView& /*memory*/) const {}
};

}  // namespace binnacle
