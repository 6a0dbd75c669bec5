// SPDX-License-Identifier: Apache-2.0
// Replaces glibc's malloc, so that what a plugin or a library allocates is counted as well (Eigen calls malloc, not
// operator new). Under AddressSanitizer and ThreadSanitizer, whose allocator stays, their malloc hooks count.
#include "allocations.hpp"

#include <malloc.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdlib>

#ifdef __has_feature  // clang's way to say it
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define BINNACLE_SANITIZER_COUNTS
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define BINNACLE_SANITIZER_COUNTS
#endif

#if defined(BINNACLE_SANITIZER_COUNTS)
#include <cstddef>
// As sanitizer/allocator_interface.h has it, which GCC does not install.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*, std::size_t),
                                                         void (*on_free)(const volatile void*));
#elif defined(__GLIBC__)
#define BINNACLE_REPLACES_MALLOC
#endif

namespace {

thread_local std::uint64_t allocation_count = 0;
std::atomic<std::int64_t> held = 0;

}  // namespace

namespace binnacle::conform {
bool allocations_are_counted() {
#if defined(BINNACLE_SANITIZER_COUNTS) || defined(BINNACLE_REPLACES_MALLOC)
  return true;
#else
  return false;
#endif
}
std::uint64_t allocations() { return allocation_count; }
bool held_bytes_are_counted() {
#ifdef BINNACLE_REPLACES_MALLOC
  return true;
#else
  return false;
#endif
}
std::int64_t held_bytes() { return held; }
}  // namespace binnacle::conform

#ifdef BINNACLE_SANITIZER_COUNTS
namespace {

__attribute__((no_sanitize("thread"))) void on_malloc(const volatile void*, std::size_t) { ++allocation_count; }
__attribute__((no_sanitize("thread"))) void on_free(const volatile void*) {}

[[maybe_unused]] const int hooks = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);

}  // namespace
#endif

#ifdef BINNACLE_REPLACES_MALLOC
namespace {

void* taken(void* memory) {
  ++allocation_count;
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
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  *memory = taken(__libc_memalign(alignment, size));
  return *memory ? 0 : ENOMEM;
}
void free(void* memory) {
  given_back(memory);
  __libc_free(memory);
}
}
#endif
