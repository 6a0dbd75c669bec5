// SPDX-License-Identifier: Apache-2.0
// Stands before glibc's malloc, so that what a plugin or a library allocates is counted as well.
#include "allocations.hpp"

#include <malloc.h>

#include <atomic>
#include <cerrno>
#include <cstddef>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define BINNACLE_COUNTS_ALLOCATIONS
#endif

namespace {

thread_local std::uint64_t count = 0;
std::atomic<std::int64_t> held = 0;

}  // namespace

namespace binnacle::conform {
std::uint64_t allocations() { return count; }
std::int64_t held_bytes() { return held; }
}  // namespace binnacle::conform

#ifdef BINNACLE_COUNTS_ALLOCATIONS
namespace {

void* taken(void* memory) {
  ++count;
  if (memory) held.fetch_add(static_cast<std::int64_t>(malloc_usable_size(memory)), std::memory_order_relaxed);
  return memory;
}
void given_back(void* memory) {
  if (memory) held.fetch_sub(static_cast<std::int64_t>(malloc_usable_size(memory)), std::memory_order_relaxed);
}

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) { return taken(__libc_malloc(size)); }
void* calloc(std::size_t number, std::size_t size) { return taken(__libc_calloc(number, size)); }
void* realloc(void* memory, std::size_t size) {
  given_back(memory);
  return taken(__libc_realloc(memory, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return taken(__libc_memalign(alignment, size)); }
void* memalign(std::size_t alignment, std::size_t size) { return taken(__libc_memalign(alignment, size)); }
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  *memory = taken(__libc_memalign(alignment, size));
  return *memory ? 0 : ENOMEM;
}
void free(void* memory) {
  given_back(memory);
  __libc_free(memory);
}
}
#endif
