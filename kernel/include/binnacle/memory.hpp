// SPDX-License-Identifier: Apache-2.0
// What a model keeps from call to call: declared by its type, kept by the kernel in the arena.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

#include "binnacle/handle.hpp"

namespace binnacle {

/// A component's memory during one call.
class MemoryView {
 public:
  constexpr MemoryView() = default;
  constexpr MemoryView(std::byte* data) noexcept : data_(data) {}

  constexpr std::byte* data() const noexcept { return data_; }
  template <class T>
  T& operator[](Memory<T> handle) const noexcept {
    return *std::launder(reinterpret_cast<T*>(data_ + handle.offset()));
  }
  template <class T>
  std::span<T> operator[](MemoryArray<T> handle) const noexcept {
    return {reinterpret_cast<T*>(data_ + handle.offset()), handle.count()};
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
    return Memory<T>(add<T>(1));
  }
  /// `count` of them, each at first T{}.
  template <class T>
  MemoryArray<T> keeps_array(std::size_t count) {
    return MemoryArray<T>(add<T>(count), count);
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

}  // namespace binnacle
