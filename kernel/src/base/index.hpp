// SPDX-License-Identifier: Apache-2.0
// Indices: plans number things with int, −1 where there is none; containers want std::size_t.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

namespace binnacle::internal::base {

constexpr std::size_t as_size(int i) { return static_cast<std::size_t>(i); }

/// How many items there are.
template <class Items>
constexpr int count_of(const Items& items) {
  return static_cast<int>(items.size());
}

/// Where the first item is whose projection is the wanted one; −1: there is none.
template <class Items, class Wanted, class Projection = std::identity>
constexpr int index_of(const Items& items, const Wanted& wanted, Projection projection = {}) {
  const auto found = std::ranges::find(items, wanted, projection);
  return found == items.end() ? -1 : static_cast<int>(found - items.begin());
}

}  // namespace binnacle::internal::base
