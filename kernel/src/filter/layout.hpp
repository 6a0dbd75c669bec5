// SPDX-License-Identifier: Apache-2.0
// Where things lie in the one contiguous arena that holds everything a run may change.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "base/index.hpp"

namespace binnacle::filter {

using base::as_size;

/// A place for `count` objects of T in an arena; the same in every arena of one composition.
template <class T>
struct Place {
  static_assert(std::is_trivially_copyable_v<T>, "a snapshot is a copy of bytes");
  std::size_t offset = 0;
  std::size_t count = 0;

  T* in(std::byte* arena) const { return reinterpret_cast<T*>(arena + offset); }
  const T* in(const std::byte* arena) const { return reinterpret_cast<const T*>(arena + offset); }
};

/// Lays places out one after the other.
class Layout {
 public:
  static constexpr std::size_t alignment = 64;  // a cache line: no strip of P lies across two

  template <class T>
  Place<T> add(std::size_t count) {
    static_assert(alignof(T) <= alignment);
    const Place<T> place{size_, count};
    size_ += (count * sizeof(T) + alignment - 1) / alignment * alignment;
    return place;
  }
  std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};

}  // namespace binnacle::filter
