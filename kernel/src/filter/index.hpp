// SPDX-License-Identifier: Apache-2.0
// Indices are int; containers want std::size_t.
#pragma once

#include <cstddef>

namespace binnacle::filter {

constexpr std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

}  // namespace binnacle::filter
