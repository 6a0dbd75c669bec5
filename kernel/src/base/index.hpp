// SPDX-License-Identifier: Apache-2.0
// Indices: plans number things with int, −1 where there is none; containers want std::size_t.
#pragma once

#include <cstddef>

namespace binnacle::base {

constexpr std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

}  // namespace binnacle::base
