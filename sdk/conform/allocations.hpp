// SPDX-License-Identifier: Apache-2.0
// How often memory was allocated by this thread, and how much is held, anywhere in the process.
#pragma once

#include <cstdint>

namespace binnacle::conform {

/// False where this C library gives no way to count: then allocations() stays 0.
bool allocations_are_counted();
/// Calls of operator new and of malloc, calloc, realloc and their aligned kin, whoever made them.
std::uint64_t allocations();
/// False under a sanitizer as well, which has an allocator of its own: then held_bytes() stays 0.
bool held_bytes_are_counted();
/// Bytes that are allocated and not freed, by all threads.
std::int64_t held_bytes();

}  // namespace binnacle::conform
