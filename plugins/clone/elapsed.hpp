// SPDX-License-Identifier: Apache-2.0
// The time between two instants.
#pragma once

#include <cstdint>

#include "binnacle/time.hpp"

namespace binnacle::clone {

/// to − from, and without overflow whatever they are.
constexpr Time elapsed(Time from, Time to) noexcept {
  return static_cast<Time>(static_cast<std::uint64_t>(to) - static_cast<std::uint64_t>(from));
}

}  // namespace binnacle::clone
