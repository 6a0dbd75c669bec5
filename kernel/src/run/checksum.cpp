// SPDX-License-Identifier: Apache-2.0
#include "run/checksum.hpp"

#define XXH_INLINE_ALL  // nothing is linked
#include <xxhash.h>

namespace binnacle::internal::runtime {

std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t start) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), start);
}

}  // namespace binnacle::internal::runtime
