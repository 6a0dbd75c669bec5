// SPDX-License-Identifier: Apache-2.0
// The checksum of files and journals: XXH3 of 64 bits.
#pragma once

#include <cstddef>
#include <cstdint>

#ifndef NDEBUG
#define XXH_NO_INLINE_HINTS 1  // GCC's -Og does not inline what the header forces
#endif
#define XXH_INLINE_ALL  // nothing is linked
#include <xxhash.h>

namespace binnacle::wording {

/// Of all bytes so far.
class Checksum {
 public:
  Checksum() { XXH3_64bits_reset(&state_); }
  void add(const void* data, std::size_t size) { XXH3_64bits_update(&state_, data, size); }
  std::uint64_t value() const { return XXH3_64bits_digest(&state_); }

 private:
  XXH3_state_t state_;
};

}  // namespace binnacle::wording
