// SPDX-License-Identifier: Apache-2.0
// How often memory was allocated by this thread, and how much is held, anywhere in the process.
#pragma once

#include <cstdint>

namespace binnacle::conform {

/// Zero for ever under a sanitizer, which has an allocator of its own.
std::uint64_t allocations();
/// Bytes that are allocated and not given back, by all threads.
std::int64_t held_bytes();

}  // namespace binnacle::conform
