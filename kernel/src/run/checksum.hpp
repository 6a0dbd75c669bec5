// SPDX-License-Identifier: Apache-2.0
// The checksum of what is kept outside of the program and read back: snapshots and checkpoints.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace binnacle::internal::runtime {

/// XXH3 of 64 bits. `start`: the checksum of what comes before.
std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t start = 0);

/// A head with a member `checksum` and what follows it, under one checksum. The head has no padding.
template <class Head>
std::uint64_t checksum_of(Head head, std::span<const std::byte> payload) {
  head.checksum = 0;
  return checksum(payload, checksum(std::as_bytes(std::span(&head, 1))));
}

}  // namespace binnacle::internal::runtime
