// SPDX-License-Identifier: Apache-2.0
// Vectors that begin with a cache line, for loops whose vector registers must not cross one.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace binnacle::internal::base {

template <class T>
struct CacheLineAllocator {
  using value_type = T;
  static constexpr std::align_val_t alignment{64};

  CacheLineAllocator() = default;
  template <class U>
  CacheLineAllocator(const CacheLineAllocator<U>&) {}  // NOLINT: allocators convert
  T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), alignment)); }
  void deallocate(T* begin, std::size_t) { ::operator delete(begin, alignment); }
  bool operator==(const CacheLineAllocator&) const { return true; }
};

template <class T>
using AlignedVector = std::vector<T, CacheLineAllocator<T>>;

}  // namespace binnacle::internal::base
